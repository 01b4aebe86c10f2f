// SPDX-License-Identifier: MIT
// Brushes in a real browser. The pointer uses each brush once, and the command line replays the
// page's result from the document. Also clay, images and colours, and a brush that is slower than
// the pointer. Usage: node test_brushes.mjs KIBORI [SCREENSHOTS]
import { spawn } from "node:child_process";
import { cpus } from "node:os";
import {
  after,
  answered,
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
  inPopover,
  lookBy,
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
const pick = (page, mode) =>
  page.locator(`input[name=brush][value=${mode}]`).check({ force: true });

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
  // Make a groove with a heap in it to work on.
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
  // The key puts the brush away, and Esc cancels a stroke.
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
  // Undo and redo.
  await page.keyboard.press("Control+z");
  await until(page, "undone", (s) => s.hash !== before.hash && !/^0*$/.test(s.hash));
  await page.keyboard.press("Control+y");
  await until(page, "redone", (s) => s.hash === before.hash);
  await page.keyboard.press("Control+o");
  await started(page);
  check("the command line carves the same", verified());
  await studio.end();
}

/** On a surface that faces the eye, to the right enlarges and to the left shrinks. */
async function scaleFromAbove() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  await begun(page, "limewood");
  await lookBy(page, "7");
  const middle = await page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
  await stroke(page, { x: middle.x - 80, y: middle.y }, { x: middle.x + 80, y: middle.y });
  let last = await after(page, "0");
  await pick(page, "scale");
  for (const [way, sign] of [
    [50, -1],
    [-50, 1],
  ]) {
    await stroke(page, middle, { x: middle.x + way, y: middle.y });
    const now = await after(page, last.step);
    const change = Number(now.volume) - Number(last.volume);
    check(`${way} pixels change the groove's volume (${change})`, sign * change > 2);
    last = now;
  }
  await page.keyboard.press("Control+o");
  await started(page);
  check("the command line carves the same", verified());
  await studio.end();
}

/**
 * In clay a tool presses. The volume stays the same, and the stroke is a step. Symmetry repeats it
 * around the axis.
 */
async function clayAndImages() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page, "clay");
  const first = await state(page);
  await inPopover(page, "#fold", async (fold) => {
    await fold.fill("3");
    await fold.dispatchEvent("change");
  });
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

/** A lump of clay on the wheel keeps its volume when it is pressed in all around. */
async function onTheWheel() {
  const studio = await Studio.start();
  const page = await open(SIZE, { reducedMotion: "no-preference" });
  await enter(page, studio.url);
  const middle = await begun(page, "clay", "1");
  const first = await state(page);
  await page.locator("input[name=mode][value=turn]").click();
  await stroke(page, middle, { x: middle.x, y: middle.y + 30 });
  const thrown = await after(page, first.step);
  check("the wheel makes another piece of it", thrown.hash !== first.hash);
  check(
    `and keeps the volume (${(Number(thrown.volume) - Number(first.volume)).toFixed(1)} mm³)`,
    Math.abs(Number(thrown.volume) / Number(first.volume) - 1) < 0.01,
  );
  await show(page, "wheel");
  // The slider's label and its number agree.
  await page.locator("input[name=brush][value=smooth]").check({ force: true });
  const strength = await page.evaluate(
    () =>
      document
        .querySelector("#brush-strength")
        .closest(".row")
        .querySelector("input[type=number], input:not([type=range])").value,
  );
  check(`half of the strength is 50 % (${strength})`, strength === "50");
  await page.locator("input[name=mode][value=turn]").click();
  // A second finger. The disc turns while the first finger presses.
  const slider = page.locator("#wall");
  check("the wheel has a second finger", await slider.isVisible());
  await slider.fill("4");
  check("shown in mm", (await page.locator("#walls").innerText()).includes("mm"));
  await page.evaluate(() => window.kibori.still(false)); // draw the turning disc
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

/** Keeps every processor busy with other work while `work` runs. */
async function busily(work) {
  const loops = [...cpus(), ...cpus()].map(() => spawn(process.execPath, ["-e", "for (;;);"]));
  try {
    return await work();
  } finally {
    for (const loop of loops) loop.kill("SIGKILL");
  }
}

const SPOTS = 40;
/** Where lines of sight through a circle on the screen meet the piece [mm]. */
const onCircle = (page, middle, radius) =>
  page.evaluate(
    ({ x, y, radius, SPOTS }) =>
      Array.from({ length: SPOTS }, (_, i) => {
        const angle = (2 * Math.PI * i) / SPOTS;
        return window.kibori.at(x + radius * Math.cos(angle), y + radius * Math.sin(angle));
      }),
    { ...middle, radius, SPOTS },
  );

/** On a busy machine dabs are slower than the pointer. They still follow its whole path. */
async function fastCircle() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page, "limewood", "2");
  await pick(page, "crease");
  await page.locator("#size").fill("1.5");
  await page.locator("#size").dispatchEvent("change");
  await answered(page);
  const first = await state(page);
  const radii = [35, 70, 105];
  const before = [];
  for (const radius of radii) before.push(await onCircle(page, middle, radius));
  const circle = async (events, from = 0) => {
    for (let i = 1; i <= events; i++) {
      const angle = (2 * Math.PI * (from + i)) / 200;
      await page.mouse.move(middle.x + 70 * Math.cos(angle), middle.y + 70 * Math.sin(angle));
    }
  };
  await hover(page, middle.x + 70, middle.y);
  await busily(async () => {
    await page.mouse.down();
    await circle(200);
    await page.mouse.up();
    await until(
      page,
      "the circle",
      (s) => Number(s.step) > Number(first.step) && s.pending === "0",
    );
  });
  await after(page, first.step);
  const depths = [];
  for (const [i, radius] of radii.entries()) {
    const now = await onCircle(page, middle, radius);
    depths.push(now.map((at, k) => Math.hypot(...at.map((x, axis) => x - before[i][k][axis]))));
  }
  const [inside, groove, outside] = depths,
    usual = [...groove].sort((a, b) => a - b)[SPOTS / 2];
  await show(page, "fast-circle");
  check(`the groove is deep (${usual.toFixed(2)} mm)`, usual > 0.1);
  check(
    `all around (${groove.map((depth) => depth.toFixed(2)).join(" ")})`,
    groove.every((depth) => depth > 0.4 * usual),
  );
  check(
    `and nowhere else (${Math.max(...inside, ...outside).toFixed(2)} mm)`,
    Math.max(...inside, ...outside) < 0.1 * usual,
  );
  // Esc drops a stroke that the brush still works on, also after the pointer was lifted.
  await page.locator("#size").fill("12");
  await page.locator("#size").dispatchEvent("change");
  await answered(page);
  const carved = await state(page);
  await hover(page, middle.x + 70, middle.y);
  await busily(async () => {
    await page.mouse.down();
    for (let i = 0; (await state(page)).pending !== "1"; i++) {
      check("the page shows that the brush is behind", i < 400);
      await circle(25, 25 * i);
    }
    await page.mouse.up();
    check("it says so", await page.locator("#pending").isVisible());
    await show(page, "brush-pending");
    await page.locator("#view").focus();
    await page.keyboard.press("Escape");
    await until(page, "nothing waits", (s) => s.pending === "0");
  });
  const rest = await atRest(page);
  check("nothing of it remains", rest.hash === carved.hash && rest.step === carved.step);
  check("the note is gone", !(await page.locator("#pending").isVisible()));
  await page.locator("#view").focus();
  await page.keyboard.press("Control+o");
  await started(page);
  check("the command line carves the same", verified());
  await studio.end();
}

// fastCircle keeps the machine busy and takes minutes: KIBORI_PART=fastCircle. BrushPath.* checks the
// same without a browser.
const parts = [everyBrush, scaleFromAbove, clayAndImages, onTheWheel];
await run(process.env.KIBORI_PART === "fastCircle" ? [fastCircle] : parts);
