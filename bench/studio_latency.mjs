// SPDX-License-Identifier: MIT
// How long from a pointer's event to the cut in the page, in a real browser that draws nothing
// meanwhile; what a stroke sends; what the page's script takes; how long from the command to a
// usable page. Usage: node studio_latency.mjs KIBORI [--quick]
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "../web/node_modules/playwright-core/index.mjs";

const kibori = process.argv[2];
const quick = process.argv.includes("--quick");
const folder = mkdtempSync(join(tmpdir(), "kibori-latency-"));
const start = async (...words) => {
  const from = performance.now();
  const studio = spawn(kibori, ["studio", "--no-browser", ...words], {
    env: { ...process.env, XDG_DATA_HOME: folder },
  });
  const url = await new Promise((found) =>
    studio.stdout.on(
      "data",
      (text) => /http:\S+/.exec(String(text)) && found(/http:\S+/.exec(String(text))[0]),
    ),
  );
  return { studio, url, from };
};
const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  headless: true,
  args: [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
  ],
});
const share = (list, p) =>
  [...list].sort((a, b) => a - b)[Math.min(list.length - 1, Math.floor(p * list.length))];
const until = async (page, holds) => {
  while (!(await page.evaluate(holds))) await page.waitForTimeout(5);
};

// To a usable page: the choice to begin with, and a document.
const starts = { choice: [], document: [] };
const times = quick ? 1 : 5;
for (let i = 0; i < times; i++)
  for (const [what, words] of [
    ["choice", []],
    ["document", [join(folder, "start.kibori")]],
  ]) {
    const { studio, url, from } = await start(...words);
    const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
    await page.goto(url);
    await page.waitForURL(`${new URL(url).origin}/`);
    await until(
      page,
      () =>
        document.body.dataset.shown === "start" ||
        (document.body.dataset.volume && Number(document.body.dataset.chunks) > 0),
    );
    starts[what].push((performance.now() - from) / 1000);
    await page.close();
    studio.kill("SIGINT");
    await new Promise((done) => studio.on("exit", done));
  }

const { studio, url } = await start(join(folder, "latency.kibori"));
const page = await browser.newPage({ viewport: { width: 1000, height: 640 } });
await page.goto(url);
await page.waitForURL(`${new URL(url).origin}/`);
await until(
  page,
  () => Number(document.body.dataset.volume) > 0 && Number(document.body.dataset.chunks) > 0,
);
await page.waitForTimeout(2500);
await page.evaluate(() => {
  window.kibori.still(true);
  window.moves = [];
  window.updates = [];
  document
    .getElementById("view")
    .addEventListener("pointerrawupdate", (event) => window.moves.push(event.timeStamp), {
      capture: true,
    });
  new PerformanceObserver((list) => {
    for (const m of list.getEntries()) window.updates.push([m.startTime, m.duration, m.detail]);
  }).observe({ entryTypes: ["measure"] });
});
const latency = [],
  script = [],
  bytes = [];
const rows = quick ? 1 : 12,
  columns = quick ? 10 : 30;
for (let row = 0; row < rows; row++) {
  const y = 220 + 9 * row;
  await page.mouse.move(514, y);
  await page.mouse.down();
  await page.waitForTimeout(400);
  await page.evaluate(() => (window.moves.length = window.updates.length = 0));
  for (let i = 1; i <= columns; i++) {
    await page.mouse.move(514 + 3 * i, y);
    await page.waitForTimeout(110);
  }
  const { moves, updates } = await page.evaluate(() => ({
    moves: window.moves,
    updates: window.updates,
  }));
  await page.mouse.up();
  await page.waitForTimeout(300);
  for (const at of moves) {
    const first = updates.find(([start]) => start >= at);
    if (first) latency.push(first[0] + first[1] - at);
  }
  script.push(...updates.map((update) => update[1]));
  bytes.push(updates.reduce((sum, update) => sum + update[2], 0));
}
await browser.close();
studio.kill("SIGINT");
await new Promise((done) => studio.on("exit", done));
console.log(
  `pointer's event to the cut in the page: p50 ${share(latency, 0.5).toFixed(1)} ms, p99 ${share(latency, 0.99).toFixed(1)} ms, most ${share(latency, 1).toFixed(1)} ms (${latency.length} moves)`,
);
console.log(
  `the page's script: p50 ${share(script, 0.5).toFixed(2)} ms, p99 ${share(script, 0.99).toFixed(2)} ms an update (${script.length} updates)`,
);
console.log(`a stroke of ${columns} moves sends ${(share(bytes, 0.5) / 1000).toFixed(0)} kB`);
console.log(
  `from the command to the choice ${share(starts.choice, 0.5).toFixed(2)} s, to a document ${share(starts.document, 0.5).toFixed(2)} s (medians of ${times})`,
);
rmSync(folder, { recursive: true, force: true });
