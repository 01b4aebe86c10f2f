// SPDX-License-Identifier: MIT
// The hand in a real browser. Quick strokes keep their end. The same path leaves the same bytes at
// any frame rate. Every tool cuts or says why not. Depth is measured from the chosen reference.
// Usage: node test_hand.mjs KIBORI [SCREENSHOTS]
import {
  atRest,
  check,
  enter,
  eventually,
  lookBy,
  open,
  pace,
  run,
  show,
  shown,
  started,
  state,
  steady,
  Studio,
  until,
  verified,
  whole,
} from "./harness.mjs";

const SIZE = { width: 1280, height: 720 };

/** A new block of a wood, seen from above. */
async function begun(page, wood, detail = "320") {
  await started(page);
  await page.locator("#wood").selectOption({ label: wood });
  await page.locator("#detail").selectOption(detail);
  await page.locator("#go").click();
  await shown(page);
  await lookBy(page, "7");
  Object.assign(mid, await page.evaluate(() => window.kibori.onScreen(window.kibori.middle())));
}
async function leave(page) {
  await page.locator("#view").focus();
  await page.keyboard.press("Control+o");
}
const choose = (page, name) =>
  page.locator(`#shapes input[aria-label="${name}"]`).check({ force: true });
const at = (page, x, y) => page.evaluate(([a, b]) => window.kibori.at(a, b), [x, y]);
/** With KIBORI_CAMPAIGN, test all combinations. Otherwise test a few of them. */
const CAMPAIGN = Boolean(process.env.KIBORI_CAMPAIGN);
/** Durations of flicks [ms]. */
const TIMES = CAMPAIGN ? [60, 100, 250, 1000] : [60, 250];
/** The middle of the piece in the window. */
const mid = { x: 0, y: 0 };

/**
 * A straight stroke whose events have their own times, 4 ms apart, independent of the sending
 * speed.
 */
async function flick(page, from, to, ms, { pressure = 0, modifiers = 0 } = {}) {
  const client = await page.context().newCDPSession(page);
  const base = Date.now() / 1000,
    steps = Math.max(2, Math.round(ms / 4));
  const send = (type, share, more = {}) =>
    client.send("Input.dispatchMouseEvent", {
      type,
      x: from.x + share * (to.x - from.x),
      y: from.y + share * (to.y - from.y),
      button: "left",
      buttons: type === "mouseReleased" ? 0 : 1,
      clickCount: 1,
      modifiers,
      timestamp: base + (share * ms) / 1000,
      ...(pressure > 0 ? { pointerType: "pen", force: pressure } : {}),
      ...more,
    });
  await client.send("Input.dispatchMouseEvent", {
    type: "mouseMoved",
    x: from.x,
    y: from.y,
    timestamp: base - 0.1,
  });
  const all = [send("mousePressed", 0)];
  for (let i = 1; i <= steps; i++) all.push(send("mouseMoved", i / steps));
  all.push(send("mouseReleased", 1));
  await Promise.all(all);
  await client.detach();
}
/** Waits until the stroke is a step and the volume is counted. */
async function stepAfter(page, step) {
  // A step in progress has no hash yet.
  await until(page, "a step", (s) => Number(s.step) > Number(step) && !/^0*$/.test(s.hash));
  await steady(page);
  return state(page);
}
async function undone(page, hash) {
  const { chunks } = await state(page);
  await page.keyboard.press("Control+z");
  // Wait for the shown surface, because depth is measured from it.
  const back = (s) => s.hash === hash && Number(s.chunks) > Number(chunks);
  await until(page, "undone", back);
  await whole(page);
}

// A groove 2 mm deep by a tool of 4 mm: its section, and the volume of both ends together.
const SECTIONS = {
  "Ball burr": [16 * Math.acos(0.5) - 2 * Math.sqrt(12), Math.PI * 4 * (4 - 2 / 3)],
  "End mill": [16, Math.PI * 32],
  "V cutter": [4, (Math.PI * 8) / 3],
  "Bull nose": [16 - 2 * (1 - Math.PI / 4) * 2.25, null],
};
// The ends of a bull nose by slices. The radius depends on the height above the tip.
SECTIONS["Bull nose"][1] = Array.from({ length: 2000 }, (_, i) => {
  const z = (i + 0.5) / 1000,
    r = z < 1.5 ? 2.5 + Math.sqrt(2.25 - (1.5 - z) ** 2) : 4;
  return (Math.PI * r * r) / 1000;
}).reduce((a, b) => a + b);

async function quickStrokes() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  for (const wood of ["limewood", "oak", "walnut"]) {
    await begun(page, wood);
    const first = await state(page);
    let slow = false;
    for (const tool of Object.keys(SECTIONS)) {
      await choose(page, tool);
      for (const ms of TIMES) {
        const from = { x: mid.x - 150, y: mid.y },
          to = { x: mid.x + 150, y: mid.y };
        const [a, b] = [await at(page, from.x, from.y), await at(page, to.x, to.y)];
        await page.evaluate((on) => window.kibori.slowFrames(on ? 33 : 0), slow);
        const before = await state(page);
        await flick(page, from, to, ms);
        const after = await stepAfter(page, before.step);
        const [section, ends] = SECTIONS[tool],
          long = Math.hypot(b[0] - a[0], b[1] - a[1]),
          expected = section * long + ends;
        const taken = Number(before.volume) - Number(after.volume);
        check(
          `${tool}, ${wood}, ${ms} ms, ${slow ? 30 : 60} Hz: ${taken.toFixed(1)} of ${expected.toFixed(1)} mm³`,
          Math.abs(taken - expected) < 0.02 * expected,
        );
        // The surface follows a moment later.
        let end = b;
        await eventually(
          () => `${tool}, ${wood}, ${ms} ms: it ends where the pointer did (${end} for ${b})`,
          async () => {
            end = await at(page, to.x, to.y);
            return Math.abs(end[2] - (b[2] - 2)) < 0.3;
          },
        );
        await undone(page, first.hash);
        slow = !slow;
      }
      if (wood !== "limewood" && !CAMPAIGN) continue;
      // The same flick at two frame rates. The times of its events are equal.
      const both = [];
      for (const frames of [0, 33]) {
        await page.evaluate((ms) => window.kibori.slowFrames(ms), frames);
        const before = await state(page);
        await flick(
          page,
          { x: mid.x - 120, y: mid.y - 60 },
          { x: mid.x + 140, y: mid.y + 70 },
          120,
        );
        both.push((await stepAfter(page, before.step)).hash);
        await undone(page, first.hash);
      }
      check(`${tool}, ${wood}: the same bytes at 60 and 30 frames a second`, both[0] === both[1]);
    }
    await page.evaluate(() => window.kibori.slowFrames(0));
    await leave(page);
  }
  check("the studio ends well", (await studio.end()) === 0);
}

/** The woods that every tool carves. Clay yields, which is a different test. */
const WOODS = CAMPAIGN ? ["oak", "limewood", "pine", "walnut", "balsa", "wax", "foam"] : ["oak"];

async function everyToolBites() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  for (const wood of WOODS) {
    await begun(page, wood, "192");
    const first = await state(page);
    const names = await page
      .locator("#shapes input")
      .evaluateAll((all) => all.map((one) => one.getAttribute("aria-label")));
    check("there are eighteen tools", names.length === 18);
    for (const name of names)
      for (const along of CAMPAIGN || name === names[0] ? ["normal", "view", "pen"] : ["normal"]) {
        const what = `${name}, ${wood}, ${along}`;
        await choose(page, name);
        await page.locator("#axis").selectOption(along);
        const before = await state(page);
        await flick(page, { x: mid.x - 100, y: mid.y }, { x: mid.x + 100, y: mid.y + 30 }, 400, {
          pressure: along === "pen" ? 0.5 : 0,
        });
        const after = await stepAfter(page, before.step);
        check(`${what}: it bites`, Number(before.volume) - Number(after.volume) > 5);
        const force = parseFloat(await page.locator("#n-force").textContent());
        check(`${what}: no force beyond the hand's strength (${force})`, force <= 200);
        await undone(page, first.hash);
      }
    await leave(page);
    await started(page);
    check(`${wood}: the command line carves every stroke to the same hash`, verified());
  }
  check("the studio ends well", (await studio.end()) === 0);
}

async function depthAndBeginnings() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  await begun(page, "limewood", "192");
  const first = await state(page);
  const volume = Number(first.volume);

  // A stroke that crosses itself cuts no deeper. It cuts deeper if depth is measured from the
  // current surface.
  const across = async () => {
    const client = await page.context().newCDPSession(page),
      base = Date.now() / 1000;
    const send = (type, x, y, t) =>
      client.send("Input.dispatchMouseEvent", {
        type,
        x,
        y,
        button: "left",
        buttons: 1,
        clickCount: 1,
        timestamp: base + t,
      });
    await send("mousePressed", mid.x - 80, mid.y, 0);
    // Move back and forth, so slowly that the page has the groove's surface when the pointer
    // returns.
    for (let i = 0; i < 80; i++) {
      await send(
        "mouseMoved",
        mid.x - 80 + 160 * (i % 40 < 20 ? (i % 20) / 20 : 1 - (i % 20) / 20),
        mid.y,
        0.03 * (i + 1),
      );
      await pace(page, 30);
    }
    await send("mouseReleased", mid.x - 80, mid.y, 2.6);
    await client.detach();
  };
  const taken = {};
  for (const from of ["began", "held", "now"]) {
    await page.locator("#depth-from").selectOption(from);
    const before = await state(page);
    await across();
    const after = await stepAfter(page, before.step);
    taken[from] = volume - Number(after.volume);
    await show(page, `hand-depth-${from}`);
    await undone(page, first.hash);
  }
  check(
    `over one's own stroke it does not dig (${JSON.stringify(taken)})`,
    Math.abs(taken.began - taken.held) < 0.03 * taken.held,
  );
  check("but from the surface as it is", taken.now > 1.3 * taken.began);
  await page.locator("#depth-from").selectOption("began");

  // A cancelled stroke changes nothing, and the page shows that nothing was removed.
  const client = await page.context().newCDPSession(page);
  await page.mouse.move(mid.x, mid.y);
  await page.mouse.down();
  for (let i = 0; i < 20; i++) await page.mouse.move(mid.x + 4 * i, mid.y);
  await page.keyboard.press("Escape");
  await page.mouse.up();
  await until(page, "as before", (s) => Number(s.volume) === volume);
  const removedText = () => page.locator("#n-removed").textContent();
  await eventually(
    "nothing is removed after Esc",
    async () => parseFloat(await removedText()) === 0,
  );
  await client.detach();

  // Outside the wood, within the tool's radius.
  let edge = mid.x;
  while (await at(page, edge, mid.y)) edge += 1;
  const before = await state(page);
  await flick(page, { x: edge + 4, y: mid.y }, { x: edge - 120, y: mid.y }, 300);
  const entered = await stepAfter(page, before.step);
  check("a gouge enters from the edge", volume - Number(entered.volume) > 20);
  await undone(page, first.hash);

  // A double click on the wood does not turn the view.
  const eye = await page.evaluate(() => window.kibori.eye());
  await page.mouse.dblclick(mid.x, mid.y);
  await atRest(page);
  check(
    "a double click on the wood does not turn it",
    JSON.stringify(await page.evaluate(() => window.kibori.eye())) === JSON.stringify(eye),
  );

  // The removed volume is also shown after reopening the document.
  const pressed = await state(page);
  await flick(page, { x: mid.x - 100, y: mid.y }, { x: mid.x + 100, y: mid.y }, 300);
  const cut = await stepAfter(page, pressed.step);
  // The number follows the state a moment later.
  const expected = (volume - Number(cut.volume)) / 1000;
  await eventually(
    async () => `${expected} cm³ are removed, not ${await removedText()}`,
    async () => Math.abs(parseFloat(await removedText()) - expected) < 0.002,
  );
  const removed = await removedText();
  check("something was removed", parseFloat(removed) > 0.1);
  await leave(page);
  await started(page);
  await page.locator("#documents button").first().click();
  await shown(page);
  await eventually(
    "the removed volume is shown again",
    async () => (await removedText()) === removed,
  );
  check("the studio ends well", (await studio.end()) === 0);
}

async function mallet() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  await begun(page, "oak", "192");
  await choose(page, "Box");
  const before = await state(page);
  await page.mouse.move(mid.x, mid.y);
  await page.mouse.down();
  await page.locator("#notice").filter({ hasText: "mallet" }).waitFor();
  check("it says what helps", /200 N/.test(await page.locator("#notice").textContent()));
  await page.keyboard.press(" ");
  await until(page, "the blow drives it in", (s) => Number(s.volume) < Number(before.volume) - 60);
  await page.mouse.up();
  check("the studio ends well", (await studio.end()) === 0);
}

/** Shift smooths with any tool. An edge becomes smooth, and the step can be undone. */
async function shiftSmooths() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  await begun(page, "limewood", "192");
  await choose(page, "End mill");
  const from = { x: mid.x - 120, y: mid.y },
    to = { x: mid.x + 120, y: mid.y };
  const before = await state(page);
  await flick(page, from, to, 250);
  const cut = await stepAfter(page, before.step);
  await flick(page, { x: mid.x, y: mid.y - 60 }, { x: mid.x, y: mid.y + 60 }, 400, {
    modifiers: 8,
  });
  const smoothed = await stepAfter(page, cut.step);
  const taken = Number(cut.volume) - Number(smoothed.volume);
  check(`smoothing moves what it should (${taken.toFixed(2)} mm³)`, Math.abs(taken) < 60);
  check("it is a step of its own", smoothed.hash !== cut.hash);
  // The next frame draws it, which may take a while.
  await page.getByText("Smooth", { exact: true }).first().waitFor();
  await undone(page, cut.hash);
  check("the studio ends well", (await studio.end()) === 0);
}

await run([quickStrokes, everyToolBites, depthAndBeginnings, mallet, shiftSmooths]);
