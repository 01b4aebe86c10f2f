// SPDX-License-Identifier: MIT
// Three pieces by a carver's own tools, through the page alone, by strokes of the mouse: a name
// plate (stamps and a V-gouge), a chip-carved rosette (V-gouge, twelve times around), a spoon
// (gouges, and two cuts of a saw).
//
//     node tools/carvers.mjs KIBORI OUT_FOLDER [plate|chipcarving|spoon ...]
//
// Into OUT_FOLDER go NAME.png and NAME.kibori, which `kibori verify` carves again.
import { execFileSync } from "node:child_process";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import {
  answered,
  check,
  eventually,
  hover,
  kibori,
  pace,
  pictures as out,
  reports,
  run,
  state,
  steady,
  until,
  whole,
} from "../tests/page/harness.mjs";
import { Bench } from "./pieces.mjs";

mkdirSync(out, { recursive: true });

/** A bench where tools stand on the wood, and depth counts from it. */
async function begin(name, stock) {
  const bench = await Bench.begin(name, stock);
  await bench.page.locator("#axis").selectOption("normal");
  await bench.page.locator("#depth-from").selectOption("began");
  return bench;
}
/** A stroke of the mouse through places, which are told from the middle of the piece [mm]. */
async function stroke(bench, places, { steps = 12, rest = 60 } = {}) {
  const { page } = bench,
    before = await state(page),
    seen = places.map((place) => bench.onScreen(place));
  await hover(page, seen[0].x, seen[0].y);
  await page.mouse.down();
  for (const { x, y } of seen.slice(1)) await page.mouse.move(x, y, { steps });
  await pace(page, rest);
  await page.mouse.up();
  await steady(page, JSON.stringify, 10);
  await until(page, "a hash", (s) => !/^0*$/.test(s.hash));
  // One that meets no wood is none.
  if (Number((await state(page)).step) === Number(before.step)) return;
  await whole(page);
  bench.strokes++;
}
const guide = (bench, what, snap = "90") =>
  bench.page
    .locator("#guide")
    .selectOption(what)
    .then(() => what === "line" && bench.page.locator("#snap").selectOption(snap));
const depth = (bench, mm) => bench.type("depth", mm);
async function pick(bench, tool, radius, form) {
  await bench.choose({ tool, radius, angle: form });
}
/** Letters of a stamp; the studio makes them. */
async function letters(bench, text, font, size, every = 0) {
  const { page } = bench,
    made = () => page.evaluate(() => window.kibori.stampsMade());
  await bench.choose({ tool: "Stamp", radius: size });
  await page.locator("#stamp-text").fill(text);
  await page.locator("#stamp-font").selectOption(font);
  await page.locator("#every").fill(String(every));
  // What was asked for in several parts is made more than once.
  await eventually("the stamp is made", async () => {
    const before = await made();
    await reports(page, 15);
    await answered(page);
    return before > 0 && (await made()) === before;
  });
}
/** A saw along a line, which is closed where its last place is its first; the larger part is waste. */
async function saw(bench, line) {
  const { page } = bench,
    seen = line.map((place) => bench.onScreen(place));
  const before = await state(page);
  await page.locator("#view").focus();
  await page.keyboard.press("k");
  await page.mouse.move(seen[0].x, seen[0].y);
  await page.mouse.down();
  for (const { x, y } of seen.slice(1)) await page.mouse.move(x, y, { steps: 2 });
  await page.mouse.up();
  const cut = await until(
    page,
    "it is cut",
    (s) => Number(s.step) > Number(before.step) && !/^0*$/.test(s.hash),
    120,
  );
  await steady(page);
  await whole(page);
  const count = await page.locator("#body-list li").count();
  check(`two bodies, not ${count}`, count === 2);
  // It is worked on still.
  await page.locator("#bodies-box summary").click();
  await page.locator("#body-remove").click();
  await until(page, "it is gone", (s) => Number(s.step) > Number(cut.step), 60);
  await page.locator("#bodies-box summary").click();
  await whole(page);
}
async function done(bench, keys, light) {
  await bench.stand(keys);
  await bench.light(...light);
  await bench.picture();
  await bench.export("kibori", `${bench.name}.kibori`);
  const told = execFileSync(kibori, ["verify", join(out, `${bench.name}.kibori`)], {
    encoding: "utf8",
  });
  check(`${bench.name} is carved again`, /all is as it was written/.test(told));
  console.log(`${bench.name}: ${bench.strokes} strokes`);
  await bench.end();
}

// ---- A name plate

async function plate() {
  const bench = await begin("plate", { stock: 0, wood: "limewood", long: 100, detail: 512 });
  await bench.look([0, 0, 1]);
  const top = 100 * (15 / 80);
  await depth(bench, 1.6);
  await letters(bench, "KIBORI", "DejaVu Serif", 7);
  await stroke(bench, [
    [0, 5, top],
    [0.1, 5, top],
  ]);
  await letters(bench, "★", "DejaVu Sans", 2, 7);
  await guide(bench, "line");
  await stroke(bench, [
    [-35, -12, top],
    [35.5, -11, top],
  ]);
  // The border: over the corners, so that they meet.
  await pick(bench, "V-gouge", 4, 90);
  await depth(bench, 1.5);
  const [x, y] = [44, 25];
  for (const [from, to] of [
    [
      [-x - 3, -y],
      [x + 3, -y],
    ],
    [
      [x, -y - 3],
      [x, y + 3],
    ],
    [
      [x + 3, y],
      [-x - 3, y],
    ],
    [
      [-x, y + 3],
      [-x, -y - 3],
    ],
  ])
    await stroke(bench, [
      [...from, top],
      [...to, top],
    ]);
  await guide(bench, "none");
  // Off the block, 10 mm thick.
  await bench.look([0, -1, 0]);
  await saw(bench, [
    [-56, -31, top - 10],
    [56, -31, top - 10],
  ]);
  await done(bench, ["+", "ArrowUp", "ArrowUp", "ArrowUp", "ArrowUp"], [-0.5, 0.45]);
}

// ---- A rosette

async function chipcarving() {
  const bench = await begin("chipcarving", { stock: 0, wood: "limewood", long: 100, detail: 512 });
  const { page } = bench,
    top = 100 * (15 / 80);
  await bench.look([0, 0, 1]);
  await page.locator("#fold").fill("12");
  await page.locator("#fold").press("Enter");
  await page.locator("#fold-axis").selectOption("2");
  const at = (r, degrees) => {
    const a = (degrees * Math.PI) / 180;
    return [r * Math.cos(a), r * Math.sin(a), top];
  };
  // Leaves, and between them shorter ones.
  await pick(bench, "V-gouge", 6, 90);
  await depth(bench, 2.6);
  await stroke(bench, [at(3.5, 0), at(22, 0)]);
  await pick(bench, "V-gouge", 4, 90);
  await depth(bench, 1.4);
  await stroke(bench, [at(13, 15), at(24.5, 15)]);
  await page.locator("#fold").fill("1");
  await page.locator("#fold").press("Enter");
  // A border of a veiner, around the middle.
  await guide(bench, "circle");
  await pick(bench, "Gouge", 1, 10);
  await depth(bench, 1);
  const round = Array.from({ length: 40 }, (_, i) => at(27.5, 5 + (i * 372) / 39));
  await stroke(bench, round, { steps: 6 });
  await guide(bench, "none");
  await done(bench, ["+", "ArrowUp", "ArrowUp", "ArrowUp", "ArrowUp"], [-0.5, 0.45]);
}

// ---- A spoon

const BOWL = { x: -32, wide: 23, high: 15.5 };
/** Half as high as the spoon is at x, seen from above. */
function halfWidth(x) {
  const bowl = (x - BOWL.x) / BOWL.wide,
    inBowl = Math.abs(bowl) < 1 ? BOWL.high * Math.sqrt(1 - bowl * bowl) : 0,
    t = (x + 14) / 64,
    handle = t < 0 || t > 1 ? 0 : 3.4 + 2.6 * t * t,
    end = t > 0.9 ? Math.sqrt(Math.max(0, 1 - ((t - 0.9) / 0.1) ** 2)) : 1;
  return Math.max(inBowl, handle * end);
}

async function spoon() {
  const bench = await begin("spoon", { stock: 0, wood: "limewood", long: 120, detail: 512 });
  const { page } = bench,
    top = 120 * (15 / 80);
  await bench.look([0, 0, 1]);
  // The hollow: along the bowl, deeper from pass to pass; a gouge goes in and comes out by itself.
  await bench.setPlane([50, 30, top]);
  await bench.type("strength", 500);
  for (const [deep, share, radius, sweep] of [
    [3, 0.8, 5, 9],
    [5.5, 0.68, 5, 9],
    [7, 0.56, 5, 8],
  ]) {
    await pick(bench, "Gouge", radius, sweep);
    await depth(bench, deep);
    const rows = Math.ceil((2 * share * BOWL.high) / 2.2);
    for (let i = 0; i < rows; i++) {
      const y = share * BOWL.high * (-1 + (2 * i + 1) / rows) * 0.9,
        half = share * BOWL.wide * Math.sqrt(Math.max(0, 1 - (y / (share * BOWL.high)) ** 2));
      if (half < 4) continue;
      const ends = [BOWL.x - half, BOWL.x + half];
      await stroke(
        bench,
        (i % 2 ? ends.reverse() : ends).map((x) => [x, y, top]),
        { steps: 20 },
      );
    }
  }
  await page.locator("#depth-from").selectOption("began");
  // Out of the block by a saw: what is seen from above, then from the front.
  const outline = [];
  for (let x = -54.9; x <= 50; x += 0.8) outline.push([x, halfWidth(x), top]);
  for (let x = 50; x >= -54.9; x -= 0.8) outline.push([x, -halfWidth(x), top]);
  await saw(bench, [...outline, outline[0]]);
  await bench.look([0, -1, 0]);
  const under = (x) => {
      // Of the bowl 11 mm, of the handle 5; between, a sweep.
      const bowl = Math.max(0, 1 - ((x - BOWL.x) / (BOWL.wide + 3)) ** 2) ** 0.5;
      return top - Math.max(4.5 + (x > 0 ? x / 50 : 0), 11.5 * bowl);
    },
    above = (x) => top - (x > -9 ? Math.min(2.2, (x + 9) * 0.2) * Math.exp(-x / 60) : 0);
  const profile = [];
  for (let x = -58; x <= 53; x += 1.5) profile.push([x, -BOWL.high, above(x) + (x < -9 ? 0.4 : 0)]);
  for (let x = 53; x >= -58; x -= 1.5) profile.push([x, -BOWL.high, under(x)]);
  await saw(bench, [...profile, profile[0]]);
  await done(bench, ["+", "+", "ArrowUp", "ArrowUp"], [-0.5, 0.5]);
}

const all = [plate, chipcarving, spoon],
  wanted = process.argv.slice(4);
await run(all.filter((piece) => wanted.length === 0 || wanted.includes(piece.name)));
