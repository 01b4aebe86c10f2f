// SPDX-License-Identifier: MIT
// Importing a file in the page: the guesses, the choices, and the resulting piece. See harness.mjs.
import { existsSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import {
  check,
  enter,
  eventually,
  fetched,
  folder,
  open,
  run,
  show,
  shown,
  started,
  Studio,
} from "./harness.mjs";

// ---- Files

/**
 * A standing figure about an axis (0 to 2), in metres, 0.156 high: feet, a body, and a nose in the
 * direction `front`.
 */
function figure(up, front, nose) {
  const side = 3 - up - front;
  const vertices = [],
    faces = [];
  const box = (low, high) => {
    const first = vertices.length;
    for (let i = 0; i < 8; i++) {
      const p = [0, 0, 0];
      p[side] = i & 1 ? high[0] : low[0];
      p[front] = nose * (i & 2 ? high[1] : low[1]);
      p[up] = i & 4 ? high[2] : low[2];
      vertices.push(p);
    }
    const quads = [
      [0, 2, 3, 1],
      [4, 5, 7, 6],
      [0, 1, 5, 4],
      [2, 6, 7, 3],
      [0, 4, 6, 2],
      [1, 3, 7, 5],
    ];
    // The faces point outward for any order of the axes.
    const even = ((front - side + 3) % 3 === 1) === nose > 0;
    for (const q of quads) faces.push((even ? q : [...q].reverse()).map((i) => first + i));
  };
  box([-0.03, -0.02, 0], [0.03, 0.04, 0.02]); // broad feet
  box([-0.02, -0.015, 0.01], [0.02, 0.015, 0.156]);
  box([-0.005, 0.01, 0.12], [0.005, 0.06, 0.13]); // the nose
  return { vertices, faces };
}
const objText = ({ vertices, faces }) =>
  vertices.map((v) => `v ${v.join(" ")}\n`).join("") +
  faces.map((f) => `f ${f.map((i) => i + 1).join(" ")}\n`).join("");
function file(name, content) {
  const path = join(folder, name);
  writeFileSync(path, content);
  return path;
}

// ---- The page

const dialogOpen = (page) => page.locator("#importing[open]");
async function choose(page, path) {
  await page.locator("#file").setInputFiles(path);
  await dialogOpen(page).waitFor();
}
const text = (page, id) => page.locator(`#${id}`).textContent();
const value = (page, id) => page.locator(`#${id}`).inputValue();
const sizes = async (page) =>
  (await text(page, "import-size")).split(" mm")[0].split(" × ").map(Number);
/** The size of the document's surface, and its vertices. */
async function vertices(page) {
  const stl = await fetched(page, "/export?format=stl"),
    points = [];
  for (let at = 84; at + 50 <= stl.length; at += 50)
    for (let i = 0; i < 3; i++)
      points.push([0, 4, 8].map((k) => stl.readFloatLE(at + 12 + 12 * i + k)));
  return points;
}
const reach = (points) =>
  [0, 1, 2].map((i) => [
    Math.min(...points.map((p) => p[i])),
    Math.max(...points.map((p) => p[i])),
  ]);
// Math.min cannot take this number of arguments at once.
const bounds = (points) =>
  points.reduce(
    (b, p) => b.map(([low, high], i) => [Math.min(low, p[i]), Math.max(high, p[i])]),
    reach(points.slice(0, 1)),
  );
const near = (a, b, within) => Math.abs(a - b) <= within;
async function importIt(page) {
  await page.locator("#importing button[value=yes]").click();
  return shown(page);
}
async function close(page) {
  await page.locator("#leave").click();
  await started(page);
}
/** True if the whole dialog is within the window, with nothing cut off sideways. */
async function fits(page) {
  return page.evaluate(() => {
    const box = document.getElementById("importing"),
      r = box.getBoundingClientRect();
    const inside = r.left >= 0 && r.top >= 0 && r.right <= innerWidth && r.bottom <= innerHeight;
    const buttons = [...box.querySelectorAll("form > .buttons button")].every(
      (b) => b.getBoundingClientRect().bottom <= innerHeight && b.getBoundingClientRect().top >= 0,
    );
    return (
      inside &&
      buttons &&
      [box, ...box.querySelectorAll("*")].every(
        (e) =>
          e.tagName === "SELECT" ||
          e.scrollWidth <= e.clientWidth + 1 ||
          e.clientWidth === 0 ||
          getComputedStyle(e).textOverflow === "ellipsis" ||
          e.tagName === "INPUT",
      )
    );
  });
}
/** The share of the wood's colour in the dialog's view. */
async function drawn(page) {
  const png = await page.locator("#import-view").screenshot();
  return page.evaluate(async (data) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height),
      pen = canvas.getContext("2d");
    pen.drawImage(image, 0, 0);
    const pixels = pen.getImageData(0, 0, image.width, image.height).data;
    let brown = 0;
    for (let i = 0; i < pixels.length; i += 4) brown += pixels[i] > pixels[i + 2] + 25 ? 1 : 0;
    return brown / (pixels.length / 4);
  }, png.toString("base64"));
}

async function begun(size) {
  const studio = await Studio.start();
  const page = await open(size);
  await enter(page, studio.url);
  await started(page);
  return { studio, page };
}
async function ended({ studio, page }) {
  await page.context().close();
  check("the studio ends well", (await studio.end()) === 0);
}

// ---- The parts

// A figure in metres with y up, like a scan. The piece is upright, 80 mm long, and of the chosen
// wood.
async function standing() {
  const at = await begun({ width: 1280, height: 720 }),
    { page } = at;
  const path = file("figure.obj", objText(figure(1, 2, 1)));
  await page.locator("#wood").selectOption("1"); // of a new piece; an import has its own choice
  await choose(page, path);
  check(
    "the unit can't be meant",
    (await value(page, "import-unit")) === "fit" &&
      /80 mm/.test(await text(page, "import-unit-why")),
  );
  check("80 mm", (await value(page, "import-longest")) === "80");
  check("y is up", (await value(page, "import-up")) === "y");
  check(
    "limewood",
    (await page.locator("#import-wood option:checked").textContent()) === "limewood",
  );
  check("its name", (await value(page, "import-name")) === "figure");
  const size = await sizes(page);
  check(
    `it stands (${size})`,
    size[2] === 80 && near(size[0], (80 * 60) / 156, 0.1) && near(size[1], (80 * 80) / 156, 0.1),
  );
  check("pieces are said", /3 pieces/.test(await text(page, "import-notes")));
  await eventually("it is drawn", async () => (await drawn(page)) > 0.03);
  check("it fits the window", await fits(page));
  await show(page, "import-figure");
  // Unit and size follow each other.
  await page.locator("#import-unit").selectOption("m");
  check("in metres", (await value(page, "import-longest")) === "156");
  await page.locator("#import-longest").fill("15.6");
  check("in centimetres?", (await value(page, "import-unit")) === "fit");
  await page.locator("#import-longest").fill("1.56");
  check("in centimetres", (await value(page, "import-unit")) === "cm");
  await page.locator("#import-unit").selectOption("fit");
  check("80 mm again", (await value(page, "import-longest")) === "80");
  // Four turns about an axis change nothing. One turn lays the figure down.
  for (const axis of ["X", "Y", "Z"]) {
    const before = await sizes(page);
    for (let i = 0; i < 4; i++) {
      await page.getByRole("button", { name: `Turn about ${axis}` }).click();
      const now = await sizes(page),
        other = "XYZ".indexOf(axis);
      check(
        "a turn changes two sides",
        now[other] === before[other] && (i % 2 === 1 || now.join() !== before.join()),
      );
    }
    check(
      "four turns",
      (await sizes(page)).join() === before.join() && (await value(page, "import-up")) === "y",
    );
  }
  await page.locator("#import-wood").selectOption({ label: "walnut" });
  await page.locator("#import-detail").selectOption("192");
  check("its pitch", /0\.417 mm/.test(await text(page, "import-detail-out")));
  await page.locator("#import-name").fill("a figure");
  await importIt(page);
  check("its title", (await page.title()).startsWith("a figure"));
  const points = await vertices(page),
    box = bounds(points);
  for (const [i, side] of [(80 * 60) / 156, (80 * 80) / 156, 80].entries())
    check(`side ${i} (${box[i]})`, near(box[i][0], 0, 0.1) && near(box[i][1], side, 0.1));
  const slice = (low, high) => bounds(points.filter((p) => p[2] > low && p[2] < high));
  const feet = slice(-1, 5),
    head = slice(70, 90);
  check("its broad feet are below", feet[0][1] - feet[0][0] > 1.4 * (head[0][1] - head[0][0]));
  // The nose looks to the front, -y, and is farther out than the feet.
  check("its nose looks to the front", near(slice(60, 68)[1][0], 0, 0.2) && feet[1][0] > 8);
  await show(page, "import-carved");
  const color = String(await fetched(page, "/export?format=obj"))
    .match(/^v .*$/m)[0]
    .split(" ")
    .slice(4)
    .map(Number);
  check(
    `it is walnut (${color})`,
    near(color[0], 121 / 255, 0.02) &&
      near(color[1], 83 / 255, 0.02) &&
      near(color[2], 54 / 255, 0.02),
  );
  await close(page);
  await ended(at);
}

// A figure whose file has another up axis, turned once more by the user. The view shows the result.
async function turned() {
  const at = await begun({ width: 1000, height: 700 }),
    { page } = at;
  await choose(page, file("z-up.stl", stl(figure(2, 1, -1), 1000)));
  check(
    "mm",
    (await value(page, "import-unit")) === "mm" && (await value(page, "import-longest")) === "156",
  );
  check("z is up", (await value(page, "import-up")) === "z");
  await page.getByRole("button", { name: "Turn about X" }).click();
  await page.getByRole("button", { name: "Turn about Z" }).click();
  const want = await sizes(page);
  check(`it lies (${want})`, want[0] === 156 && want[2] === 80);
  check("up is shown", (await value(page, "import-up")) !== "z");
  await page.locator("#import-detail").selectOption("192");
  await importIt(page);
  const box = bounds(await vertices(page));
  for (let i = 0; i < 3; i++)
    check(
      `side ${i} (${box[i]} of ${want[i]})`,
      near(box[i][0], 0, 0.2) && near(box[i][1], want[i], 0.3),
    );
  await close(page);
  await ended(at);
}
function stl({ vertices: at, faces }, scale) {
  const triangles = faces.flatMap((f) => [
    [f[0], f[1], f[2]],
    [f[0], f[2], f[3]],
  ]);
  return `solid t\n${triangles.map((t) => `facet normal 0 0 0\nouter loop\n${t.map((i) => `vertex ${at[i].map((x) => x * scale).join(" ")}\n`).join("")}endloop\nendfacet\n`).join("")}endsolid t\n`;
}

// Cancel drops the file. An invalid file gets one sentence. The user can correct a detail that is
// too coarse or too fine.
async function refused() {
  const at = await begun({ width: 1000, height: 700 }),
    { page } = at;
  const path = file("figure.obj", objText(figure(1, 2, 1)));
  const made = () =>
      existsSync(join(folder, "kibori"))
        ? readdirSync(join(folder, "kibori")).filter((name) => name.endsWith(".kibori")).length
        : 0,
    before = made();
  const dropped = page.waitForRequest(
    (r) => r.method() === "DELETE" && r.url().includes("/import?"),
  );
  await choose(page, path);
  await page.locator("#importing button[value=no]").click();
  check("the file is dropped", (await (await dropped).response()).status() === 204);
  check("the dialog is closed", !(await page.locator("#importing").isVisible()));
  await choose(page, path); // the same file again
  const escaped = page.waitForRequest((r) => r.method() === "DELETE");
  await page.keyboard.press("Escape");
  check("Escape drops it, too", (await (await escaped).response()).status() === 204);
  check("nothing was made", made() === before);
  for (const [name, content] of [
    ["none.stl", "no mesh at all"],
    ["none.obj", "v 0 0 0\n"],
    ["none.png", "no picture"],
    ["none.txt", "words"],
  ]) {
    await page.locator("#file").setInputFiles(file(name, content));
    const output = page.locator("#notice").filter({
      hasText: name === "none.txt" ? /can't be carved/ : new RegExp(`(?<!Reading )${name}`),
    });
    await output.waitFor();
    const words = (await output.textContent()).trim();
    check(
      `one sentence: ${words}`,
      !words.includes("\n") && !words.includes("import.") && words.length < 250,
    );
    check("no dialog", !(await page.locator("#importing").isVisible()));
  }
  // A file chosen while another is being read replaces it.
  await page.locator("#file").setInputFiles(file("none.stl", "no mesh at all"));
  await choose(page, path);
  check(
    "the file that was chosen last",
    (await page.locator("#import-title").textContent()) === "Import figure.obj",
  );
  await page.locator("#import-longest").fill("20000");
  await page.locator("#importing button[value=yes]").click();
  check("a size that can't be is not sent", await page.locator("#importing").isVisible());
  await page.locator("#import-longest").fill("0.1");
  await page.locator("#import-name").fill("");
  // The studio refuses while other work runs. The choices stay, and the message is shown with them.
  await page.route(
    "**/make?**",
    (route) => route.fulfill({ status: 422, body: "that is too coarse; choose more detail\n" }),
    { times: 1 },
  );
  await page.locator("#importing button[value=yes]").click();
  await page.locator("#import-trouble", { hasText: "too coarse" }).waitFor();
  check("what was chosen stays", (await value(page, "import-longest")) === "0.1");
  await show(page, "import-trouble");
  await page.locator("#import-longest").fill("50");
  await page.locator("#import-detail").selectOption("192");
  await importIt(page);
  await close(page);
  await ended(at);
}

// By keyboard alone, from the file button to the finished import.
async function byKeyboard() {
  const at = await begun({ width: 1280, height: 720 }),
    { page } = at;
  const path = file("keys.obj", objText(figure(1, 2, 1)));
  await page.locator("#file").focus();
  // On a busy machine Chromium sometimes opens its own invisible dialog before it reports it to the
  // test.
  const opening = page.waitForEvent("filechooser");
  const again = setInterval(() => void page.keyboard.press("Enter"), 5000);
  await page.keyboard.press("Enter");
  const chooser = await opening.finally(() => clearInterval(again));
  check("the focus stays", (await page.evaluate(() => document.activeElement.id)) === "file");
  await chooser.setFiles(path);
  await dialogOpen(page).waitFor();
  const focused = () =>
    page.evaluate(
      () =>
        document.activeElement.id || document.activeElement.value || document.activeElement.tagName,
    );
  const seen = [];
  for (let i = 0; i < 20; i++) {
    seen.push(await focused());
    await page.keyboard.press("Tab");
  }
  for (const id of [
    "import-name",
    "import-unit",
    "import-longest",
    "import-up",
    "X",
    "Y",
    "Z",
    "import-wood",
    "import-detail",
    "no",
    "yes",
  ])
    check(`${id} is reached (${seen})`, seen.includes(id));
  const goTo = async (id) => {
    for (let i = 0; i < 30 && (await focused()) !== id; i++) await page.keyboard.press("Tab");
    check(`at ${id}`, (await focused()) === id);
  };
  await goTo("import-longest");
  await page.keyboard.press("Control+a");
  await page.keyboard.type("40");
  await goTo("Z");
  await page.keyboard.press("Enter");
  check("turned, and not imported", (await dialogOpen(page).count()) === 1);
  await goTo("import-wood");
  await page.keyboard.type("oak");
  await goTo("import-detail");
  await page.keyboard.press("ArrowUp");
  await goTo("yes");
  await page.keyboard.press("Enter");
  await shown(page);
  const box = bounds(await vertices(page));
  check(
    `40 mm high (${box[2]}), turned (${box[0]})`,
    near(box[2][1], 40, 0.1) && near(box[0][1], (40 * 80) / 156, 0.2),
  );
  await close(page);
  await ended(at);
}

// On a phone and on a small laptop. A picture has other choices, and a document has none.
async function windows() {
  for (const [name, size] of [
    ["phone", { width: 390, height: 844 }],
    ["laptop", { width: 1280, height: 720 }],
  ]) {
    const at = await begun(size),
      { page } = at;
    await choose(page, file("figure.obj", objText(figure(1, 2, 1))));
    check(`${name}: it fits the window`, await fits(page));
    await eventually(`${name}: it is drawn`, async () => (await drawn(page)) > 0.02);
    await show(page, `import-${name}`);
    await page.locator("#importing button[value=no]").click();
    // A picture: a slope from black on the left to white on the right.
    const png = await page.evaluate(() => {
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [64, 32];
      const pen = canvas.getContext("2d"),
        slope = pen.createLinearGradient(0, 0, 64, 0);
      slope.addColorStop(0, "black");
      slope.addColorStop(1, "white");
      pen.fillStyle = slope;
      pen.fillRect(0, 0, 64, 32);
      return canvas.toDataURL("image/png").split(",")[1];
    });
    await choose(page, file("slope.png", Buffer.from(png, "base64")));
    check(
      "no turns for a picture",
      !(await page.locator("#import-turns").isVisible()) &&
        !(await page.locator("#import-unit").isVisible()),
    );
    await page.locator("#import-height").fill("12");
    await page.locator("#import-base").fill("3");
    await page.locator("#import-invert").check();
    check(`its size (${await sizes(page)})`, (await sizes(page)).join() === "80,40,15");
    check(`${name}: the picture fits`, await fits(page));
    await show(page, `import-${name}-picture`);
    await page.locator("#import-detail").selectOption("192");
    await importIt(page);
    const points = await vertices(page),
      left = bounds(points.filter((p) => p[0] < 5)),
      right = bounds(points.filter((p) => p[0] > 75));
    check(
      `black is highest (${left[2]}, ${right[2]})`,
      near(left[2][1], 15, 0.5) && right[2][1] < 5,
    );
    if (name === "laptop") {
      file("taken.kibori", await fetched(page, "/export?format=kibori"));
      await close(page);
      await page.locator("#file").setInputFiles(join(folder, "taken.kibori"));
      await shown(page);
      check(
        "a document opens at once",
        !(await page.locator("#importing").isVisible()) && (await page.title()).startsWith("taken"),
      );
    }
    await close(page);
    await ended(at);
  }
}

// The models next to this repository, if they exist. Each is upright, 80 mm long, and is drawn.
async function models() {
  const shared = new URL("../../../shared/models/", import.meta.url);
  if (!existsSync(shared)) return console.log("models: skipped, ../shared/models is not here");
  const at = await begun({ width: 1280, height: 720 }),
    { page } = at;
  for (const name of readdirSync(shared).filter((n) => n.endsWith(".obj"))) {
    await choose(page, file(name, readFileSync(new URL(name, shared))));
    check(`${name}: 80 mm`, Math.max(...(await sizes(page))) === 80);
    await eventually(`${name}: it is drawn`, async () => (await drawn(page)) > 0.02);
    await show(page, `import-${name.replace(".obj", "")}`);
    await page.locator("#importing button[value=no]").click();
  }
  await ended(at);
}

// A labelled volume. Its labels have names, each gets a material, and the piece contains them.
async function labels() {
  const at = await begun({ width: 1280, height: 720 }),
    { page } = at;
  await choose(page, fileURLToPath(new URL("../../examples/molar.nrrd", import.meta.url)));
  const rows = page.locator("#import-labels label");
  check("three labels", (await rows.count()) === 3);
  check("enamel is named", /enamel, [\d.]+ mm³/i.test(await rows.nth(0).textContent()));
  check(
    "no unit, size, turns or single wood",
    !(await page.locator("#import-unit").isVisible()) &&
      !(await page.locator("#import-longest").isVisible()) &&
      !(await page.locator("#import-wood").isVisible()),
  );
  const size = await sizes(page);
  check(`its grid (${size})`, size.join() === "12,11.2,20");
  await rows.nth(0).locator("select").selectOption({ label: "wax" });
  await rows.nth(1).locator("select").selectOption({ label: "oak" });
  await rows.nth(2).locator("select").selectOption({ label: "clay" });
  await eventually("it is drawn", async () => (await drawn(page)) > 0.02);
  check("it fits the window", await fits(page));
  await show(page, "import-labels");
  await page.locator("#import-detail").selectOption("192");
  await importIt(page);
  await show(page, "import-labels-made");
  const colors = new Set(
    String(await fetched(page, "/export?format=obj"))
      .match(/^v .*$/gm)
      .map((line) => line.split(" ").slice(4).join()),
  );
  // Two materials are outside. The third one, the pulp, may be visible at the roots' ends.
  check(`of its materials (${colors.size})`, colors.size >= 2 && colors.size <= 3);
  await close(page);
  await ended(at);
}

await run([standing, turned, refused, byKeyboard, windows, models, labels]);
