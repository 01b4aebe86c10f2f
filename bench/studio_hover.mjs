// SPDX-License-Identifier: MIT
// Measures the studio's page in Chromium without a graphics card at 1280 x 720. It reports frames
// per second, and processor time per frame. Other work on the machine changes the second figure
// little. The pointer hovers over the solid, the camera turns, and a stroke is carved. The solid is
// a new block of medium detail with half a million triangles.
//
// Usage: node bench/studio_hover.mjs KIBORI [SECONDS | --quick]
import { readdirSync, readFileSync } from "node:fs";
import {
  atRest,
  browser,
  enter,
  pace,
  run,
  shown,
  started,
  steady,
  Studio,
} from "../tests/page/harness.mjs";

const argument = process.argv[3] ?? "8";
const seconds = argument === "--quick" ? 2 : Number(argument);
const studio = await Studio.start();
const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
// Count only frames in which the page asked to draw.
await page.addInitScript(() => {
  const ask = window.requestAnimationFrame.bind(window);
  window.painted = [];
  window.requestAnimationFrame = (draw) =>
    ask((now) => {
      if (window.painted.at(-1) !== now) window.painted.push(now);
      draw(now);
    });
});
await enter(page, studio.url);
await started(page);
await page.locator("#go").click();
await shown(page);
const triangles = await page.evaluate(() => {
  const bytes = window.kibori.surface(),
    view = new DataView(bytes.buffer);
  let sum = 0;
  for (let at = 0; at < bytes.length; ) {
    const vertices = view.getUint32(at + 6, true),
      many = view.getUint32(at + 10, true);
    sum += many;
    const painted = view.getUint16(at + 14, true);
    at += 16 + (painted ? 14 : 10) * vertices + 6 * many;
  }
  return sum;
});
console.log(`${triangles} triangles`);

/**
 * Processor time of the browser's processes [s]: the descendants of this process except the studio.
 */
function used() {
  const processes = new Map();
  for (const id of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      const fields = readFileSync(`/proc/${id}/stat`, "utf8")
        .replace(/^.*\) /, "")
        .split(" ");
      processes.set(Number(id), {
        parent: Number(fields[1]),
        ticks: Number(fields[11]) + Number(fields[12]),
      });
    } catch {
      // The process has ended.
    }
  }
  let ticks = 0;
  for (const [id, own] of processes)
    for (let at = id; at > 1 && at !== studio.process.pid; at = processes.get(at)?.parent ?? 0)
      if (at === process.pid && id !== process.pid) ticks += own.ticks;
  return ticks / 100;
}

async function measure(what, button) {
  await page.mouse.move(700, 330);
  if (button) await page.mouse.down({ button });
  await steady(page);
  await page.evaluate(() => (window.painted.length = 0));
  const start = Date.now(),
    before = used();
  for (let i = 0; Date.now() - start < 1000 * seconds; i++) {
    await page.mouse.move(700 + 90 * Math.sin(i / 13), 330 + 40 * Math.cos(i / 17));
    await pace(page, 8);
  }
  const painted = await page.evaluate(() => window.painted),
    work = used() - before;
  if (button) await page.mouse.up({ button });
  const gaps = painted
    .slice(1)
    .map((at, i) => at - painted[i])
    .sort((a, b) => a - b);
  if (gaps.length === 0) return console.log(`${what}: fewer than two frames in ${seconds} s`);
  const share = (x) => gaps[Math.min(gaps.length - 1, Math.floor(x * gaps.length))] ?? NaN;
  console.log(
    `${what}: ${(gaps.length / ((painted.at(-1) - painted[0]) / 1000)).toFixed(1)} frames/s (between frames: p50 ${share(0.5).toFixed(0)} ms, p99 ${share(0.99).toFixed(0)} ms; ${gaps.length} frames, ${((1000 * work) / painted.length).toFixed(0)} ms of processor each)`,
  );
  await atRest(page);
}
await run([
  async function frames() {
    await measure("hover", null);
    await measure("turning the camera", "right");
    await measure("carving", "left");
    await studio.end();
  },
]);
