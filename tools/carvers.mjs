// SPDX-License-Identifier: MIT
// Carves three pieces with a carver's tools, through the page alone, by mouse strokes. The name
// plate uses stamps and a V-gouge. The chip-carved rosette uses a V-gouge, twelve times around. The
// spoon uses gouges and two saw cuts.
//
//     node tools/carvers.mjs KIBORI OUT_FOLDER [plate|chipcarving|spoon ...]
//
// Writes NAME.png and NAME.kibori to OUT_FOLDER. `kibori verify` carves the documents again.
import { execFileSync } from "node:child_process";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import {
  answered,
  check,
  eventually,
  hover,
  inPopover,
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

/** A bench whose tools are normal to the wood. Depth is measured from the wood. */
async function begin(name, stock) {
  const bench = await Bench.begin(name, stock);
  await bench.page.locator("#axis").selectOption("normal");
  await bench.page.locator("#depth-from").selectOption("began");
  return bench;
}
/** A mouse stroke through positions relative to the middle of the piece [mm]. */
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
  // A stroke that meets no wood makes no step.
  if (Number((await state(page)).step) === Number(before.step)) return;
  await whole(page);
  bench.strokes++;
}
async function guide({ page }, what, snap = "90") {
  await inPopover(page, "#guide", (one) => one.selectOption(what));
  if (what === "line") await inPopover(page, "#snap", (one) => one.selectOption(snap));
}
async function around({ page }, fold) {
  await inPopover(page, "#fold", async (one) => {
    await one.fill(String(fold));
    await one.press("Enter");
  });
}
const depth = (bench, mm) => bench.type("depth", mm);
async function pick(bench, tool, radius, form) {
  await bench.choose({ tool, radius, angle: form });
}
/** Chooses a stamp of letters and waits until the studio has made it. */
async function letters(bench, text, font, size, every = 0) {
  const { page } = bench,
    made = () => page.evaluate(() => window.kibori.stampsMade());
  await bench.choose({ tool: "Stamp", radius: size });
  await page.locator("#stamp-text").fill(text);
  await page.locator("#stamp-font").selectOption(font);
  await page.locator("#every").fill(String(every));
  // Each changed control requests the stamp again. Wait for the last one.
  await eventually("the stamp is made", async () => {
    const before = await made();
    await reports(page, 15);
    await answered(page);
    return before > 0 && (await made()) === before;
  });
}
/** Saws along a line, which is closed if it ends where it began. Removes the larger part. */
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
  // The larger part is still the active body.
  await page.locator("#bodies-box summary").click();
  await page.locator("#body-remove").click();
  await until(page, "it is gone", (s) => Number(s.step) > Number(cut.step), 60);
  await page.locator("#bodies-box summary").click();
  await whole(page);
}
async function done(bench, keys, light) {
  await bench.setView(keys);
  await bench.light(...light);
  await bench.picture();
  await bench.export("kibori", `${bench.name}.kibori`);
  const output = execFileSync(kibori, ["verify", join(out, `${bench.name}.kibori`)], {
    encoding: "utf8",
  });
  check(`${bench.name} is carved again`, /steps, .*no differences/.test(output));
  console.log(`${bench.name}: ${bench.strokes} strokes`);
  await bench.end();
}

// ---- Name plate

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
  // The border. The strokes pass over the corners, so that they meet.
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
  // Saw it off the block, 10 mm thick.
  await bench.look([0, -1, 0]);
  await saw(bench, [
    [-56, -31, top - 10],
    [56, -31, top - 10],
  ]);
  await done(bench, ["+", "ArrowUp", "ArrowUp", "ArrowUp", "ArrowUp"], [-0.5, 0.45]);
}

// ---- Rosette

async function chipcarving() {
  const bench = await begin("chipcarving", { stock: 0, wood: "limewood", long: 100, detail: 512 });
  const { page } = bench,
    top = 100 * (15 / 80);
  await bench.look([0, 0, 1]);
  await around(bench, 12);
  await inPopover(page, "#fold-axis", (one) => one.selectOption("2"));
  const at = (r, degrees) => {
    const a = (degrees * Math.PI) / 180;
    return [r * Math.cos(a), r * Math.sin(a), top];
  };
  // Leaves, with shorter ones between them.
  await pick(bench, "V-gouge", 6, 90);
  await depth(bench, 2.6);
  await stroke(bench, [at(3.5, 0), at(22, 0)]);
  await pick(bench, "V-gouge", 4, 90);
  await depth(bench, 1.4);
  await stroke(bench, [at(13, 15), at(24.5, 15)]);
  await around(bench, 1);
  // A border around the middle, cut with a veiner.
  await guide(bench, "circle");
  await pick(bench, "Gouge", 1, 10);
  await depth(bench, 1);
  const round = Array.from({ length: 40 }, (_, i) => at(27.5, 5 + (i * 372) / 39));
  await stroke(bench, round, { steps: 6 });
  await guide(bench, "none");
  await done(bench, ["+", "ArrowUp", "ArrowUp", "ArrowUp", "ArrowUp"], [-0.5, 0.45]);
}

// ---- Spoon

const BOWL = { x: -32, wide: 23, high: 15.5 };
/** Half the spoon's height at x, seen from above. */
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
  // Hollows the bowl along its length, deeper with each pass. The guide makes the gouge enter and
  // leave the wood.
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
  // Saw it out of the block by two outlines: from above, then from the front.
  const outline = [];
  for (let x = -54.9; x <= 50; x += 0.8) outline.push([x, halfWidth(x), top]);
  for (let x = 50; x >= -54.9; x -= 0.8) outline.push([x, -halfWidth(x), top]);
  await saw(bench, [...outline, outline[0]]);
  await bench.look([0, -1, 0]);
  const under = (x) => {
      // The bowl is 11 mm high and the handle 5 mm, with a curve between them.
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
