import { defineConfig } from "vite";

export default defineConfig({
  base: "/",
  // The page's own policy allows no data in scripts and no inlined styles.
  build: {
    target: "es2022",
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 1000,
    rollupOptions: { input: ["index.html", "pair.html"] },
  },
});
