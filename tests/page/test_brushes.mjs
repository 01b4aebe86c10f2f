// SPDX-License-Identifier: MIT
// Brushes in a real browser: each is picked up once, driven by the pointer, and what the page shows
// of it is what the command line carves again from the document; clay; images; colours.
// Usage: node test_brushes.mjs KIBORI [SCREENSHOTS]
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

async function begun(page, wood, shape = "0") {
  await started(page);
  await page.locator(`input[name=stock][value="${shape}"]`).check();
  await page.locator("#wood").selectOption({ label: wood });
  await page.locator("#detail").selectOption("192");
  await page.locator("#go").click();
  await shown(page);
  await page.locator("#view").focus();
  return page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
}
/** A stroke by the pointer, in so many moves. */
async function drag(page, from, to, { moves = 12, key = null } = {}) {
  await page.mouse.move(from.x, from.y);
  await page.waitForTimeout(200);
  if (key) await page.keyboard.down(key);
  await page.mouse.down();
  for (let i = 1; i <= moves; i++)
    await page.mouse.move(
      from.x + ((to.x - from.x) * i) / moves,
      from.y + ((to.y - from.y) * i) / moves,
    );
  await page.waitForTimeout(100);
  await page.mouse.up();
  if (key) await page.keyboard.up(key);
}
/** Once the step has a hash and the surface has followed. */
async function after(page, step) {
  await until(page, "a step", (s) => Number(s.step) > Number(step) && !/^0*$/.test(s.hash), 60);
  for (let i = 0; i < 300 && !(await page.evaluate(() => window.kibori.settled())); i++)
    await page.waitForTimeout(50);
  await page.waitForTimeout(300);
  return state(page);
}
/** What the command line says of the newest document: every step carved again. */
function verified() {
  const documents = join(folder, "kibori");
  const [newest] = readdirSync(documents)
    .filter((name) => name.endsWith(".kibori"))
    .sort()
    .reverse();
  return execFileSync(kibori, ["verify", join(documents, newest)], { encoding: "utf8" });
}
const pick = (page, mode) => page.locator(`input[name=mode][value=${mode}]`).check({ force: true });

const MODES = [
  "inflate",
  "smooth",
  "rasp",
  "fill",
  "flatten",
  "crease",
  "grab",
  "nudge",
  "twist",
  "bend",
  "pinch",
  "scale",
  "node",
  "paint",
];

async function everyBrush() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page, "limewood");
  // Something to work on: a furrow, and a heap in it.
  let last = await state(page);
  await drag(page, { x: middle.x - 110, y: middle.y }, { x: middle.x + 110, y: middle.y });
  last = await after(page, last.step);
  const hashes = new Set([last.hash]);
  for (const [i, mode] of MODES.entries()) {
    await pick(page, mode);
    check(`${mode} shows its brush`, await page.locator("#brush").isVisible());
    const y = middle.y + 6 * (i % 5) - 10,
      x = middle.x - 80 + 12 * i;
    await drag(page, { x, y }, { x: x + 34, y: y - 26 });
    last = await after(page, last.step);
    check(`${mode} leaves another piece`, !hashes.has(last.hash));
    hashes.add(last.hash);
  }
  await show(page, "every-brush");
  const colours = await page.evaluate(() => {
    const bytes = window.kibori.surface(),
      view = new DataView(bytes.buffer);
    let painted = 0;
    for (let at = 0; at < bytes.length; ) {
      const vertices = view.getUint32(at + 6, true),
        triangles = view.getUint32(at + 10, true),
        any = view.getUint16(at + 14, true);
      at += 16 + 10 * vertices + 6 * triangles;
      if (!any) continue;
      for (let v = 0; v < vertices; v++) painted += bytes[at + 4 * v + 3] === 255;
      at += 4 * vertices;
    }
    return painted;
  });
  check(`paint is seen (${colours} vertices)`, colours > 20);
  // The key lays the brush down, and Esc leaves a stroke off.
  await page.locator("#view").focus();
  await page.keyboard.press("a");
  check("the key picks the tool up again", await page.locator("#shapes").isVisible());
  await page.keyboard.press("g");
  check("and the brush", (await page.locator("#brush-out").textContent()) === "Grab");
  const before = await state(page);
  await page.mouse.move(middle.x - 40, middle.y - 20);
  await page.mouse.down();
  await page.mouse.move(middle.x - 40, middle.y - 60, { steps: 5 });
  await page.waitForTimeout(400);
  await page.keyboard.press("Escape");
  await page.mouse.up();
  await page.waitForTimeout(500);
  check("Esc leaves the stroke off", (await state(page)).hash === before.hash);
  // Back and forth.
  await page.keyboard.press("Control+z");
  await until(page, "undone", (s) => s.hash !== before.hash && !/^0*$/.test(s.hash), 30);
  await page.keyboard.press("Control+y");
  await until(page, "redone", (s) => s.hash === before.hash, 30);
  await page.keyboard.press("Control+o");
  await started(page);
  const said = verified();
  check(`the command line carves the same: ${said}`, /all is as it was written/.test(said));
  await studio.end();
}

/** In clay a tool presses: the volume stays, and the stroke is a step; images go round. */
async function clayAndImages() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page, "clay");
  const first = await state(page);
  await page.locator("#fold").fill("3");
  await page.locator("#fold").dispatchEvent("change");
  await drag(page, { x: middle.x + 40, y: middle.y }, { x: middle.x + 90, y: middle.y - 20 });
  const pressed = await after(page, first.step);
  check("the piece is another", pressed.hash !== first.hash);
  let volume = 0;
  for (let i = 0; i < 60; i++) {
    volume = Number((await state(page)).volume);
    if (Math.abs(volume - Number(first.volume)) < 0.5) break;
    await page.waitForTimeout(250);
  }
  check(
    `clay keeps its volume (${(volume - Number(first.volume)).toFixed(3)} mm³)`,
    Math.abs(volume - Number(first.volume)) < 0.5,
  );
  await show(page, "clay");
  await page.locator("#view").focus();
  await page.keyboard.press("Control+o");
  await started(page);
  check("carved again, too", /all is as it was written/.test(verified()));
  await studio.end();
}

/** A lump of clay on the wheel: pressed in all around, it keeps its volume. */
async function onTheWheel() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page, "clay", "1");
  const first = await state(page);
  await page.locator("input[name=mode][value=turn]").check();
  await drag(page, middle, { x: middle.x, y: middle.y + 30 });
  const thrown = await after(page, first.step);
  check("the wheel makes another piece of it", thrown.hash !== first.hash);
  check(
    `and keeps the volume (${(Number(thrown.volume) - Number(first.volume)).toFixed(1)} mm³)`,
    Math.abs(Number(thrown.volume) / Number(first.volume) - 1) < 0.01,
  );
  await show(page, "wheel");
  // What a slider says is what its number says.
  await page.locator("input[name=mode][value=smooth]").check({ force: true });
  const strength = await page.evaluate(
    () =>
      document
        .querySelector("#brush-strength")
        .closest(".row")
        .querySelector("input[type=number], input:not([type=range])").value,
  );
  check(`half of the strength is 50 % (${strength})`, strength === "50");
  await page.locator("input[name=mode][value=turn]").check();
  // A second finger, and the disc beneath turns while the first presses.
  const slider = page.locator("#wall");
  check("the wheel has a second finger", await slider.isVisible());
  await slider.fill("4");
  check("told in mm", (await page.locator("#walls").innerText()).includes("mm"));
  await page.mouse.move(middle.x, middle.y + 60);
  await page.waitForTimeout(200);
  await page.mouse.down();
  await page.mouse.move(middle.x, middle.y + 80, { steps: 8 });
  const frames = () => page.evaluate(() => window.kibori.frames());
  const before = await frames();
  for (let i = 0; i < 300 && (await frames()) < before + 3; i++) await page.waitForTimeout(100);
  check("the wheel turns while the hand rests on it", (await frames()) >= before + 3);
  await show(page, "wheel-turning");
  await page.mouse.up();
  await after(page, thrown.step);
  await page.locator("#view").focus();
  await page.keyboard.press("Control+o");
  await started(page);
  check("carved again, too", /all is as it was written/.test(verified()));
  await studio.end();
}

await run([everyBrush, clayAndImages, onTheWheel]);
