// SPDX-License-Identifier: MIT
// Carvers' tools and guided strokes in a real browser: each tool is picked up once and driven by the
// pointer at its defaults, and what the page shows is what the command line carves again; strokes on
// lines, circles and the way of another stroke; a hand that is steadied.
// Usage: node test_carver.mjs KIBORI [SCREENSHOTS]
import { execFileSync } from "node:child_process";
import { readdirSync } from "node:fs";
import { join } from "node:path";
import {
  check,
  enter,
  folder,
  kibori,
  open,
  run,
  show,
  shown,
  started,
  state,
  Studio,
  until,
} from "./harness.mjs";

const SIZE = { width: 1280, height: 800 };

async function begun(page, wood) {
  await started(page);
  await page.locator("#wood").selectOption({ label: wood });
  await page.locator("#detail").selectOption("192");
  await page.locator("#go").click();
  await shown(page);
  await page.locator("#view").focus();
  await page.keyboard.press("7");
  await page.waitForTimeout(1200);
  return page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
}
/** A stroke by the pointer through these places. */
async function drag(page, places) {
  await page.mouse.move(places[0].x, places[0].y);
  await page.waitForTimeout(200);
  await page.mouse.down();
  for (const { x, y } of places.slice(1)) await page.mouse.move(x, y, { steps: 8 });
  await page.waitForTimeout(100);
  await page.mouse.up();
}
/** Once the step has a hash and the surface has followed. */
async function after(page, step) {
  await until(page, "a step", (s) => Number(s.step) > Number(step) && !/^0*$/.test(s.hash), 60);
  for (let i = 0; i < 300 && !(await page.evaluate(() => window.kibori.settled())); i++)
    await page.waitForTimeout(50);
  await page.waitForTimeout(300);
  return state(page);
}
function verified() {
  const documents = join(folder, "kibori");
  const [newest] = readdirSync(documents)
    .filter((name) => name.endsWith(".kibori"))
    .sort()
    .reverse();
  return execFileSync(kibori, ["verify", join(documents, newest)], { encoding: "utf8" });
}
async function ended(page, studio) {
  await page.locator("#view").focus();
  await page.keyboard.press("Control+o");
  await started(page);
  check("carved again by the command line", /all is as it was written/.test(verified()));
  await studio.end();
}
const choose = (page, name) =>
  page.locator(`#shapes input[aria-label="${name}"]`).check({ force: true });
const at = (page, { x, y }) => page.evaluate(([a, b]) => window.kibori.at(a, b), [x, y]);

const TOOLS = [
  ["Gouge", "Sweep"],
  ["V-gouge", "Angle"],
  ["Chisel", "Bevel"],
  ["Skew chisel", "Skew"],
  ["Knife", "Point"],
  ["Lollipop cutter", "Neck"],
  ["T-slot cutter", "Height"],
];

async function everyTool() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page, "limewood");
  let last = await state(page);
  const top = (await at(page, middle))[2];
  for (const [i, [name, form]] of TOOLS.entries()) {
    await choose(page, name);
    check(`${name} is held`, (await page.locator("#shape-out").textContent()) === name);
    check(`${name} has its ${form}`, (await page.locator("#form-name").textContent()) === form);
    const leads = i < 5;
    check(`${name} leads itself, or not`, (await page.locator("#leading").isVisible()) === leads);
    const y = middle.y - 105 + 35 * i;
    await drag(page, [
      { x: middle.x - 170, y },
      { x: middle.x + 170, y },
    ]);
    const now = await after(page, last.step);
    check(`${name} cuts`, Number(last.volume) - Number(now.volume) > 5);
    if (leads && i < 2) {
      // Its channel is as deep as it was told in the middle (as far as a pixel can tell), and ends at the surface on both sides.
      const depth = (x) => at(page, { x: middle.x + x, y }).then((p) => top - p[2]);
      const [before, within, behind] = [await depth(-180), await depth(0), await depth(180)];
      check(`${name} is 2 mm deep (${within})`, within > 1.6 && within < 2.1);
      check(`${name} went in and out (${before}, ${behind})`, before < 0.05 && behind < 0.05);
    }
    if (i === 0) await show(page, "gouge");
    last = now;
  }
  await show(page, "carvers-tools");
  await page.keyboard.press("1");
  await page.waitForTimeout(1200);
  await ended(page, studio);
}

async function guidedStrokes() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page, "walnut");
  const first = await state(page);
  const top = (await at(page, middle))[2];
  await choose(page, "V-gouge");
  const depth = (x, y) =>
    at(page, { x: middle.x + x, y: middle.y + y }).then((p) => Number((top - p[2]).toFixed(3)));
  const go = async (places) => {
    const before = await state(page);
    await drag(
      page,
      places.map(([x, y]) => ({ x: middle.x + x, y: middle.y + y })),
    );
    return after(page, before.step);
  };
  const undone = async () => {
    await page.keyboard.press("Control+z");
    await until(page, "undone", (s) => s.hash === first.hash, 60);
    await page.waitForTimeout(600);
  };

  // A line along the axes: the hand wanders, the cut does not.
  await page.locator("#guide").selectOption("line");
  check("a line asks for directions", await page.locator("#snaps").isVisible());
  await page.locator("#snap").selectOption("90");
  await go([
    [-150, 0],
    [-60, 8],
    [0, -14],
    [60, 12],
    [150, -6],
  ]);
  for (const x of [-90, -30, 30, 90])
    check(`the line is straight at ${x}`, (await depth(x, 0)) > 1.8 && (await depth(x, 22)) < 0.05);
  await show(page, "guide-line");
  await undone();

  // A circle about the middle.
  await page.locator("#guide").selectOption("circle");
  check("which circle is told", await page.locator("#circle-help").isVisible());
  const round = Array.from({ length: 13 }, (_, i) => {
    const a = (i * Math.PI) / 8,
      r = i === 0 ? 100 : 100 + (i % 2 ? 14 : -12);
    return [r * Math.cos(a), r * Math.sin(a)];
  });
  await go(round);
  for (const a of [0.7, 1.6, 2.6, 3.4])
    check(
      `the circle is one at ${a}`,
      (await depth(100 * Math.cos(a), 100 * Math.sin(a))) > 1.5 &&
        (await depth(60 * Math.cos(a), 60 * Math.sin(a))) < 0.05,
    );
  await show(page, "guide-circle");
  await undone();

  // The way of another stroke, which was only felt.
  await page.locator("#guide").selectOption("none");
  await page.locator("input[name=mode][value=touch]").check({ force: true });
  const wave = Array.from({ length: 21 }, (_, i) => [-150 + 15 * i, 40 * Math.sin(i / 3)]);
  await drag(
    page,
    wave.map(([x, y]) => ({ x: middle.x + x, y: middle.y + y })),
  );
  await page.locator("input[name=mode][value=cut]").check({ force: true });
  await page.locator("#guide").selectOption("curve");
  check("a stroke was made", !(await page.locator("#curve-help").isVisible()));
  await go(wave.map(([x, y], i) => [x, y + (i % 2 && i > 1 ? 9 : 0)]));
  for (const i of [6, 9, 12, 15]) {
    const [x, y] = wave[i];
    check(`the cut is on the curve at ${x}`, (await depth(x, y)) > 1.4);
  }
  await show(page, "guide-curve");
  await page.locator("#guide").selectOption("none");

  // A string between the hand and the tool: the tremor is not carved.
  await page.locator("#steady").fill("5");
  check("the string is told", (await page.locator("#steady-out").textContent()) === "5.0 mm");
  await go(Array.from({ length: 60 }, (_, i) => [-150 + 5 * i, 100 + (i % 2 ? 7 : -7)]));
  for (const x of [-60, 0, 60]) check(`the string steadies at ${x}`, (await depth(x, 122)) < 0.05);
  await show(page, "guide-steady");
  await page.locator("#steady").fill("0");
  // The whole is as the command line has it.
  await ended(page, studio);
}

/** Distances, an angle, a wall, and what the piece weighs, before and after a cut. */
async function measures() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page, "limewood");
  const told = async (id) => page.locator(`#measure-${id}`).textContent();
  const first = await state(page);
  check("nothing is measured unless one asks", !(await page.locator("#measures").isVisible()));
  await page.keyboard.press("Shift+M");
  check("Shift+M measures", await page.locator("#measures").isVisible());
  const corner = { x: middle.x - 60, y: middle.y + 20 };
  const places = [
    { x: middle.x + 80, y: middle.y + 20 },
    corner,
    { x: corner.x, y: corner.y - 70 },
  ];
  const points = [];
  for (const place of places) {
    points.push(await at(page, place));
    await page.mouse.move(place.x, place.y);
    await page.mouse.down();
    await page.mouse.up();
  }
  const apart = Math.hypot(...points[2].map((x, i) => x - points[1][i]));
  check(
    `the distance of the last two (${await told("distance")}, ${apart})`,
    Math.abs(parseFloat(await told("distance")) - apart) < 0.02,
  );
  check(
    `a right angle (${await told("angle")})`,
    Math.abs(parseFloat(await told("angle")) - 90) < 1,
  );
  check(
    `30 mm of wood (${await told("wall")})`,
    Math.abs(parseFloat(await told("wall")) - 30) < 0.05,
  );
  const weight = async (grams) => {
    for (let i = 0; i < 200; i++) {
      if (Math.abs(parseFloat(await told("mass")) - grams) < 0.001 * grams) return true;
      await page.waitForTimeout(50);
    }
    return false;
  };
  check(`120 cm³ of lime (${await told("mass")})`, await weight(120 * 0.53));
  const centre = (await told("centre")).split(/\s+/).map(Number);
  check(
    `in the middle (${centre})`,
    [40, 25, 15].every((x, i) => Math.abs(x - centre[i]) < 0.06),
  );
  await show(page, "measures");
  check("measuring cuts nothing", (await state(page)).hash === first.hash);
  await page.keyboard.press("Escape");
  check("Escape leaves it off", !(await page.locator("#measures").isVisible()));
  await drag(page, [
    { x: middle.x + 40, y: middle.y },
    { x: middle.x + 160, y: middle.y },
  ]);
  const cut = await after(page, first.step);
  await page.keyboard.press("Shift+M");
  check("it weighs less", await weight((Number(cut.volume) / 1000) * 0.53));
  const moved = Number((await told("centre")).split(/\s+/)[0]);
  check(`the centre moves away from the cut (${moved})`, moved < centre[0]);
  await ended(page, studio);
}

await run([everyTool, guidedStrokes, measures]);
