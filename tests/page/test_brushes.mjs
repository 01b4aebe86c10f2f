// SPDX-License-Identifier: MIT
// Brushes in a real browser: each is picked up once, driven by the pointer, and what the page shows
// of it is what the command line carves again from the document; clay; images; colours.
// Usage: node test_brushes.mjs KIBORI [SCREENSHOTS]
import {
  after,
  atRest,
  check,
  drag,
  enter,
  eventually,
  hover,
  kibori,
  open,
  pace,
  run,
  show,
  shown,
  started,
  state,
  Studio,
  until,
  verified,
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
const stroke = (page, from, to) => drag(page, [from, to], { steps: 12 });
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
  await stroke(page, { x: middle.x - 110, y: middle.y }, { x: middle.x + 110, y: middle.y });
  last = await after(page, last.step);
  const hashes = new Set([last.hash]);
  for (const [i, mode] of MODES.entries()) {
    await pick(page, mode);
    check(`${mode} shows its brush`, await page.locator("#brush").isVisible());
    const y = middle.y + 6 * (i % 5) - 10,
      x = middle.x - 80 + 12 * i;
    await stroke(page, { x, y }, { x: x + 34, y: y - 26 });
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
  await pace(page, 400);
  await page.keyboard.press("Escape");
  await page.mouse.up();
  check("Esc leaves the stroke off", (await atRest(page)).hash === before.hash);
  // Back and forth.
  await page.keyboard.press("Control+z");
  await until(page, "undone", (s) => s.hash !== before.hash && !/^0*$/.test(s.hash));
  await page.keyboard.press("Control+y");
  await until(page, "redone", (s) => s.hash === before.hash);
  await page.keyboard.press("Control+o");
  await started(page);
  check("the command line carves the same", verified());
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
  await stroke(page, { x: middle.x + 40, y: middle.y }, { x: middle.x + 90, y: middle.y - 20 });
  const pressed = await after(page, first.step);
  check("the piece is another", pressed.hash !== first.hash);
  await until(
    page,
    `clay keeps its volume of ${first.volume} mm³`,
    (s) => Math.abs(Number(s.volume) - Number(first.volume)) < 0.5,
  );
  await show(page, "clay");
  await page.locator("#view").focus();
  await page.keyboard.press("Control+o");
  await started(page);
  check("carved again, too", verified());
  await studio.end();
}

/** A lump of clay on the wheel: pressed in all around, it keeps its volume. */
async function onTheWheel() {
  const studio = await Studio.start();
  const page = await open(SIZE, { reducedMotion: "no-preference" });
  await enter(page, studio.url);
  const middle = await begun(page, "clay", "1");
  const first = await state(page);
  await page.locator("input[name=mode][value=turn]").check();
  await stroke(page, middle, { x: middle.x, y: middle.y + 30 });
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
  await page.evaluate(() => window.kibori.still(false)); // what turns is drawn
  await hover(page, middle.x, middle.y + 60);
  await page.mouse.down();
  await page.mouse.move(middle.x, middle.y + 80, { steps: 8 });
  const drawings = () => page.evaluate(() => window.kibori.frames());
  const before = await drawings();
  await eventually(
    "the wheel turns while the hand rests on it",
    async () => (await drawings()) >= before + 3,
  );
  await show(page, "wheel-turning");
  await page.mouse.up();
  await after(page, thrown.step);
  await page.locator("#view").focus();
  await page.keyboard.press("Control+o");
  await started(page);
  check("carved again, too", verified());
  await studio.end();
}

await run([everyBrush, clayAndImages, onTheWheel]);
