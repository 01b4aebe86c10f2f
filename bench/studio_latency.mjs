// SPDX-License-Identifier: MIT
// Measures the studio in a real browser, while the page does not draw. It reports the time from a
// pointer event until the page has the surface of the cut, and the bytes per stroke. It also
// reports the time of the page's script, and the time from the command to a usable page.
//
// Usage: node studio_latency.mjs KIBORI [--quick]
import { join } from "node:path";
import {
  browser,
  enter,
  eventually,
  folder,
  pace,
  run,
  shown,
  state,
  steady,
  Studio,
  until,
} from "../tests/page/harness.mjs";

const quick = process.argv.includes("--quick");
const share = (list, p) =>
  [...list].sort((a, b) => a - b)[Math.min(list.length - 1, Math.floor(p * list.length))];

// Measures the time to a usable page: to the start page, and to an open document.
const starts = { choice: [], document: [] };
const times = quick ? 1 : 5;
for (let i = 0; i < times; i++)
  for (const [what, words] of [
    ["choice", []],
    ["document", [join(folder, "start.kibori")]],
  ]) {
    const from = performance.now(),
      studio = await Studio.start(...words);
    const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
    await enter(page, studio.url);
    const usable = () =>
      document.body.dataset.shown === "start" ||
      (document.body.dataset.volume && Number(document.body.dataset.chunks) > 0);
    while (!(await page.evaluate(usable))); // asked as often as the page can answer
    starts[what].push((performance.now() - from) / 1000);
    await page.close();
    await studio.end();
  }

const studio = await Studio.start(join(folder, "latency.kibori"));
const page = await browser.newPage({ viewport: { width: 1000, height: 640 } });
await enter(page, studio.url);
await shown(page);
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
  const before = await state(page);
  await page.mouse.down();
  await eventually(
    "the tool is in the wood",
    async () => Number((await state(page)).volume) < Number(before.volume),
  );
  await steady(page);
  await page.evaluate(() => (window.moves.length = window.updates.length = 0));
  for (let i = 1; i <= columns; i++) {
    await page.mouse.move(514 + 3 * i, y);
    await pace(page, 110);
  }
  const { moves, updates } = await page.evaluate(() => ({
    moves: window.moves,
    updates: window.updates,
  }));
  await page.mouse.up();
  await until(page, "a step", (s) => Number(s.step) > Number(before.step));
  for (const at of moves) {
    const first = updates.find(([start]) => start >= at);
    if (first) latency.push(first[0] + first[1] - at);
  }
  script.push(...updates.map((update) => update[1]));
  bytes.push(updates.reduce((sum, update) => sum + update[2], 0));
}
await studio.end();
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
await run([]);
