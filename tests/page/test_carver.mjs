// SPDX-License-Identifier: MIT
// Carvers' tools and guided strokes in a real browser. The pointer uses each tool once at its
// defaults, and the command line replays the page's result. Strokes follow lines, circles and the
// path of another stroke. Also a steadied hand, and stamps of letters, a picture and a mesh.
//
// Usage: node test_carver.mjs KIBORI [SCREENSHOTS]
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
  lookBy,
  open,
  reports,
  run,
  show,
  shown,
  started,
  state,
  Studio,
  until,
  verified,
  pace,
  inPopover,
} from "./harness.mjs";

const SIZE = { width: 1280, height: 800 };

async function begun(page, wood) {
  await started(page);
  await page.locator("#wood").selectOption({ label: wood });
  await page.locator("#detail").selectOption("192");
  await page.locator("#go").click();
  await shown(page);
  await lookBy(page, "7");
  return page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
}
/** A pointer stroke through these positions, in up to eight moves from each to the next. */
const stroke = (page, places) =>
  drag(page, places, { steps: (distance) => Math.min(8, Math.ceil(distance / 8)) });
async function ended(page, studio) {
  await page.locator("#view").focus();
  await page.keyboard.press("Control+o");
  await started(page);
  check("carved again by the command line", verified());
  await studio.end();
}
const choose = (page, name) =>
  page.locator(`#shapes input[aria-label="${name}"]`).check({ force: true });
const at = (page, { x, y }) => page.evaluate(([a, b]) => window.kibori.at(a, b), [x, y]);

// Tools that can follow the stroke.
const LEADING = [
  ["Gouge", "Sweep"],
  ["V-gouge", "Angle"],
  ["Chisel", "Bevel"],
  ["Skew chisel", "Skew"],
  ["Knife", "Point"],
];

async function everyTool() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page, "limewood");
  let last = await state(page);
  const top = (await at(page, middle))[2];
  const names = await page
    .locator("#shapes input")
    .evaluateAll((inputs) => inputs.map((input) => input.ariaLabel));
  const others = names.slice(names.indexOf("Knife") + 1, names.indexOf("Stamp"));
  const tools = [...LEADING, ...others.map((name) => [name])];
  for (const [i, [name, form]] of tools.entries()) {
    await choose(page, name);
    check(`${name} is held`, (await page.locator("#shape-out").textContent()) === name);
    if (form)
      check(`${name} has its ${form}`, (await page.locator("#form-name").textContent()) === form);
    const leads = i < LEADING.length;
    check(`${name} leads itself, or not`, (await page.locator("#leading").isVisible()) === leads);
    const y = middle.y - 105 + (210 / (tools.length - 1)) * i;
    await stroke(page, [
      { x: middle.x - 170, y },
      { x: middle.x + 170, y },
    ]);
    const now = await after(page, last.step);
    check(`${name} cuts`, Number(last.volume) - Number(now.volume) > 5);
    if (leads && i < 2) {
      // In the middle the channel has the set depth, within the precision of a pixel. It ends at
      // the surface on both sides.
      const depth = (x) => at(page, { x: middle.x + x, y }).then((p) => top - p[2]);
      const [before, within, behind] = [await depth(-180), await depth(0), await depth(180)];
      check(`${name} is 2 mm deep (${within})`, within > 1.6 && within < 2.1);
      check(`${name} went in and out (${before}, ${behind})`, before < 0.05 && behind < 0.05);
    }
    if (i === 0) await show(page, "gouge");
    last = now;
  }
  await show(page, "carvers-tools");
  await lookBy(page, "1");
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
    await stroke(
      page,
      places.map(([x, y]) => ({ x: middle.x + x, y: middle.y + y })),
    );
    return after(page, before.step);
  };
  const undone = async () => {
    await page.keyboard.press("Control+z");
    await until(page, "undone", (s) => s.hash === first.hash);
    await atRest(page);
  };

  // A line along the axes. The hand wanders, but the cut stays straight.
  await inPopover(page, "#guide", (one) => one.selectOption("line"));
  check(
    "a line asks for directions",
    await page.locator("#snaps").evaluate((part) => !part.hidden),
  );
  await inPopover(page, "#snap", (one) => one.selectOption("90"));
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
  // The second side of a frame begins on the wall at the end of the first side. It is also
  // straight.
  const corner = await state(page);
  await go([
    [138, 3],
    [140, 40],
    [143, 75],
    [141, 110],
  ]);
  for (const y of [30, 60, 90])
    check(
      `the second side is straight at ${y}`,
      (await depth(138, y)) > 1.5 && (await depth(129, y)) < 0.05 && (await depth(147, y)) < 0.05,
    );
  await show(page, "guide-frame");
  await page.keyboard.press("Control+z");
  await until(page, "one undone", (s) => s.hash === corner.hash);
  await undone();

  // A circle about the middle.
  await inPopover(page, "#guide", (one) => one.selectOption("circle"));
  await inPopover(page, "#guide", async () =>
    check("the circle is explained", await page.locator("#circle-help").isVisible()),
  );
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

  // The guide is the path of another stroke, which was made in mode "Feel".
  await inPopover(page, "#guide", (one) => one.selectOption("none"));
  await page.locator("input[name=mode][value=touch]").check({ force: true });
  const wave = Array.from({ length: 21 }, (_, i) => [-150 + 15 * i, 40 * Math.sin(i / 3)]);
  await stroke(
    page,
    wave.map(([x, y]) => ({ x: middle.x + x, y: middle.y + y })),
  );
  await page.locator("input[name=mode][value=cut]").check({ force: true });
  await inPopover(page, "#guide", (one) => one.selectOption("curve"));
  check("a stroke was made", !(await page.locator("#curve-help").isVisible()));
  await go(wave.map(([x, y], i) => [x, y + (i % 2 && i > 1 ? 9 : 0)]));
  for (const i of [6, 9, 12, 15]) {
    const [x, y] = wave[i];
    check(`the cut is on the curve at ${x}`, (await depth(x, y)) > 1.4);
  }
  await show(page, "guide-curve");
  await inPopover(page, "#guide", (one) => one.selectOption("none"));

  // Steady: a string between hand and tool. The hand's tremor does not reach the wood.
  await inPopover(page, "#steady", (one) => one.fill("5"));
  check(
    "the string's length is shown",
    (await page.locator("#steady-out").textContent()) === "5.0 mm",
  );
  await go(Array.from({ length: 60 }, (_, i) => [-150 + 5 * i, 100 + (i % 2 ? 7 : -7)]));
  for (const x of [-60, 0, 60]) check(`the string steadies at ${x}`, (await depth(x, 122)) < 0.05);
  await show(page, "guide-steady");
  await inPopover(page, "#steady", (one) => one.fill("0"));

  // A brush follows a guide too. Inflating along a line makes a straight ridge.
  await inPopover(page, "#guide", (one) => one.selectOption("line"));
  await page.locator("input[name=brush][value=inflate]").check({ force: true });
  await page.locator("#size").fill("3");
  await go([
    [-140, -100],
    [-40, -112],
    [40, -88],
    [140, -104],
  ]);
  for (const x of [-80, 0, 80]) {
    const [ridge, outside] = [-(await depth(x, -100)), -(await depth(x, -130))];
    check(
      `a brush keeps to the line at ${x} (${ridge}, ${outside})`,
      ridge > 0.1 && outside < 0.02,
    );
  }
  await show(page, "guide-brush");
  // The command line gets the same result.
  await ended(page, studio);
}

/** Measures distances, an angle, a wall, and the mass of the piece, before and after a cut. */
async function measures() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page, "limewood");
  const reported = async (id) => page.locator(`#measure-${id}`).textContent();
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
    `the distance of the last two (${await reported("distance")}, ${apart})`,
    Math.abs(parseFloat(await reported("distance")) - apart) < 0.02,
  );
  check(
    `a right angle (${await reported("angle")})`,
    Math.abs(parseFloat(await reported("angle")) - 90) < 1,
  );
  check(
    `30 mm of wood (${await reported("wall")})`,
    Math.abs(parseFloat(await reported("wall")) - 30) < 0.05,
  );
  const weight = (what, grams) =>
    eventually(
      async () => `${what}: ${await reported("mass")}, not ${grams} g`,
      async () => Math.abs(parseFloat(await reported("mass")) - grams) < 0.001 * grams,
    );
  await weight("120 cm³ of lime", 120 * 0.53);
  const centre = (await reported("centre")).split(/\s+/).map(Number);
  check(
    `in the middle (${centre})`,
    [40, 25, 15].every((x, i) => Math.abs(x - centre[i]) < 0.06),
  );
  await show(page, "measures");
  check("measuring cuts nothing", (await state(page)).hash === first.hash);
  await page.keyboard.press("Escape");
  check("Escape leaves it off", !(await page.locator("#measures").isVisible()));
  await stroke(page, [
    { x: middle.x + 40, y: middle.y },
    { x: middle.x + 160, y: middle.y },
  ]);
  const cut = await after(page, first.step);
  await page.keyboard.press("Shift+M");
  await weight("it weighs less", (Number(cut.volume) / 1000) * 0.53);
  const moved = Number((await reported("centre")).split(/\s+/)[0]);
  check(`the centre moves away from the cut (${moved})`, moved < centre[0]);
  await ended(page, studio);
}

/** The print check reports a wall that is too thin after carving. */
async function printing() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  await begun(page, "limewood");
  const reported = (id) => page.locator(`#faults-${id}`).textContent();
  await page.keyboard.press("Shift+P");
  check("Shift+P checks", await page.locator("#faults").isVisible());
  await eventually("a block hangs nowhere", async () => (await reported("overhang")) === "none");
  check("it has no thin walls", (await reported("thin")) === "none");
  check("nor loose pieces", (await reported("loose")) === "none");
  // An end mill of 4 mm along the edge leaves a wall of 0.7 mm. The wall is as high as the cut is
  // deep.
  await choose(page, "End mill");
  await page.locator("#size").fill("4");
  await page.locator("#depth").fill("6");
  await answered(page);
  await pace(page, 200);
  const before = await state(page);
  const on = (x) => page.evaluate((at) => window.kibori.onScreen(at), [x, 4.7, 30]);
  await stroke(page, [await on(10), await on(70)]);
  await after(page, before.step);
  const area = async () => parseFloat(await reported("thin"));
  // Both sides of the wall count. It is 60 to 68 mm long and 6 mm high.
  await eventually("a thin wall is reported", async () => /cm²/.test(await reported("thin")));
  check(`its area (${await reported("thin")})`, (await area()) > 6 && (await area()) < 9);
  const thinnest = parseFloat(await reported("thinnest"));
  check(`how thin it is (${thinnest})`, Math.abs(thinnest - 0.7) < 0.15);
  await lookBy(page, "1");
  await show(page, "print-check");
  // Uses the pointer, as a user does.
  await page.locator("#thin-wall").click();
  await page.locator("#thin-wall").fill("0.3");
  await page.locator("#thin-wall").press("Enter");
  await eventually("thinner walls are none", async () => (await reported("thin")) === "none");
  await page.locator("#view").focus();
  await page.keyboard.press("Shift+P");
  check("and it is left off", !(await page.locator("#faults").isVisible()));
  await ended(page, studio);
}

/** A mesh of a pyramid on its point, 6 mm wide and high. */
const PYRAMID = `solid p
${[
  [
    [0, 0, 0],
    [-3, 3, 6],
    [3, 3, 6],
  ],
  [
    [0, 0, 0],
    [3, 3, 6],
    [3, -3, 6],
  ],
  [
    [0, 0, 0],
    [3, -3, 6],
    [-3, -3, 6],
  ],
  [
    [0, 0, 0],
    [-3, -3, 6],
    [-3, 3, 6],
  ],
  [
    [-3, -3, 6],
    [3, -3, 6],
    [3, 3, 6],
  ],
  [
    [-3, -3, 6],
    [3, 3, 6],
    [-3, 3, 6],
  ],
]
  .map(
    (t) =>
      `facet normal 0 0 0\nouter loop\n${t.map((p) => `vertex ${p.join(" ")}`).join("\n")}\nendloop\nendfacet`,
  )
  .join("\n")}
endsolid p
`;

async function stamps() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page, "walnut");
  const top = (await at(page, middle))[2];
  const depth = (x, y) => at(page, { x: middle.x + x, y: middle.y + y }).then((p) => top - p[2]);
  const pressed = async (places) => {
    const before = await state(page);
    await stroke(
      page,
      places.map(([x, y]) => ({ x: middle.x + x, y: middle.y + y })),
    );
    const now = await after(page, before.step);
    return Number(before.volume) - Number(now.volume);
  };
  const made = () => page.evaluate(() => window.kibori.stampsMade());
  /** Requests another stamp and waits until the studio has made it. */
  const reported = async (ask) => {
    let count = await made();
    await ask();
    await eventually("a stamp is made", async () => (await made()) > count);
    // Each changed control requests the stamp again.
    await eventually("the last stamp is made", async () => {
      count = await made();
      await reports(page, 10);
      await answered(page);
      return (await made()) === count;
    });
  };

  await choose(page, "Stamp");
  check("a stamp has its panel", await page.locator("#stamp").isVisible());
  check("no motor, no mallet", !(await page.locator("#motor").isVisible()));
  await page.locator("#stamp-font option").nth(1).waitFor({ state: "attached" });
  await eventually("a stamp is made", async () => (await made()) > 0);
  await reported(() => page.locator("#size").fill("5"));
  await hover(page, middle.x, middle.y - 40);
  await show(page, "stamp-held");
  // Letters, pressed once by a click. Their area is 121 mm2.
  const taken = await pressed([[0, -70]]);
  check(`the letters are in the wood (${taken} mm3)`, Math.abs(taken - 244) < 10);
  const along = [];
  for (let x = -150; x <= 150; x += 2) along.push(await depth(x, -70));
  const deep = along.filter((d) => d > 1.7 && d < 2.1).length,
    flat = along.filter((d) => d < 0.1).length;
  check(`strokes of letters, and wood between (${deep}, ${flat})`, deep > 12 && flat > 60);
  check(
    "nothing else",
    along.every((d) => d < 2.1),
  );
  await show(page, "stamp-letters");
  // A letter and its mirror image. A mirrored F differs.
  await inPopover(page, "#symmetry input", (one) => one.check());
  await reported(() => page.locator("#stamp-text").fill("F"));
  const twice = await pressed([[100, 120]]);
  await show(page, "stamp-mirrored");
  const both = [];
  for (let x = -130; x <= 130; x += 2) both.push((await depth(x, 120)) > 1);
  check(
    `a letter is its image mirrored (${both.map(Number).join("")})`,
    both.includes(true) && both.filter((cut, i) => cut !== both[both.length - 1 - i]).length < 4,
  );
  await page.keyboard.press("Control+z");
  await inPopover(page, "#symmetry input", (one) => one.uncheck());
  await atRest(page);
  const once = await pressed([[100, 120]]);
  check(`it was mirrored (${twice}, ${once})`, Math.abs(twice - 2 * once) < 0.1 * once);
  await page.keyboard.press("Control+z");
  await atRest(page);
  // Stars along a straight line.
  await reported(async () => {
    await page.locator("#stamp-text").fill("★");
    await page.locator("#stamp-font").selectOption("DejaVu Sans");
    await page.locator("#every").fill("8");
  });
  await inPopover(page, "#guide", (one) => one.selectOption("line"));
  await inPopover(page, "#snap", (one) => one.selectOption("90"));
  const stars = await pressed([
    [-160, 30],
    [0, 44],
    [160, 20],
  ]);
  await inPopover(page, "#guide", (one) => one.selectOption("none"));
  const row = [];
  for (let x = -170; x <= 170; x += 2) row.push((await depth(x, 30)) > 1);
  const count = row.filter((deep, i) => deep && !row[i - 1]).length;
  check(`a row of stars (${count}, ${stars} mm3)`, count >= 4 && count <= 8);
  await show(page, "stamp-stars");
  // A mesh from a file.
  await reported(async () => {
    await page.locator("#every").fill("0");
    await page.locator("#stamp-what").selectOption("2");
    await page
      .locator("#stamp-file")
      .setInputFiles({ name: "pyramid.stl", mimeType: "model/stl", buffer: Buffer.from(PYRAMID) });
  });
  const point = await pressed([[-100, 110]]);
  // It is 10 mm wide and high. At 2 mm depth the pyramid is 2 mm wide.
  check(`a pyramid's point (${point} mm3)`, Math.abs(point - (2 * 2 * 2) / 3) < 0.3);
  // A picture that the page draws itself, with dark letters.
  const png = await page.evaluate(() => {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 64;
    const draw = canvas.getContext("2d");
    const light = draw.createRadialGradient(32, 32, 4, 32, 32, 30);
    light.addColorStop(0, "white");
    light.addColorStop(1, "black");
    draw.fillStyle = light;
    draw.fillRect(0, 0, 64, 64);
    return canvas.toDataURL("image/png").split(",")[1];
  });
  await reported(async () => {
    await page.locator("#stamp-what").selectOption("1");
    await page.locator("#stamp-file").setInputFiles({
      name: "bowl.png",
      mimeType: "image/png",
      buffer: Buffer.from(png, "base64"),
    });
  });
  const bowl = await pressed([[60, 110]]);
  check(`a hollow from a picture (${bowl} mm3)`, bowl > 35 && bowl < 60);
  const hollow = await depth(60, 110);
  check(`its middle is deepest (${hollow})`, Math.abs(hollow - 2) < 0.15);
  // An invalid picture gives a message, and the stamp stays.
  await page.locator("#stamp-file").setInputFiles({
    name: "broken.png",
    mimeType: "image/png",
    buffer: Buffer.from("no picture"),
  });
  await page.locator("#notice", { hasText: "broken.png" }).waitFor();
  await show(page, "stamps");
  await ended(page, studio);
}

await run([everyTool, guidedStrokes, measures, printing, stamps]);
