// SPDX-License-Identifier: MIT
// The View panel. Each control has its effect on the picture, by mouse and by keyboard alone.
// Picking respects the section. Usage: node test_look.mjs KIBORI [SCREENSHOTS' FOLDER]
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import {
  after,
  browser,
  check,
  drawn,
  enter,
  eventually,
  folder,
  open,
  pace,
  reports,
  run,
  show,
  shown,
  started,
  state,
  Studio,
  until,
} from "./harness.mjs";

const blank = await browser.newPage(); // reads pictures

/**
 * The mean difference of two pictures' channels, and the share of pixels that differ by more than
 * 10.
 */
const compare = (a, b) =>
  blank.evaluate(
    async (pictures) => {
      const [one, other] = await Promise.all(
        pictures.map(async (text) => {
          const bitmap = await createImageBitmap(
            new Blob([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))]),
          );
          const canvas = new OffscreenCanvas(bitmap.width, bitmap.height),
            context = canvas.getContext("2d");
          context.drawImage(bitmap, 0, 0);
          return context.getImageData(0, 0, bitmap.width, bitmap.height).data;
        }),
      );
      let sum = 0,
        signed = 0,
        differ = 0;
      for (let i = 0; i < one.length; i += 4) {
        let largest = 0;
        for (let k = 0; k < 3; k++) {
          sum += Math.abs(one[i + k] - other[i + k]);
          signed += one[i + k] - other[i + k];
          largest = Math.max(largest, Math.abs(one[i + k] - other[i + k]));
        }
        if (largest > 10) differ++;
      }
      return {
        mean: sum / one.length,
        signed: signed / one.length,
        share: (4 * differ) / one.length,
      };
    },
    [a.toString("base64"), b.toString("base64")],
  );

// Max mean difference of two pictures of the same view. A slow view draws fewer pixels, which
// softens edges. The changes that the checks make cause a difference of 6 or more.
const SAME = 2;
const CLIP = { x: 240, y: 110, width: 390, height: 300 }; // the solid next to the panels
async function picture(page) {
  await drawn(page);
  return page.screenshot({ clip: CLIP });
}
const choose = (page, name, value) => page.locator(`input[name=${name}][value=${value}]`).check();
const slide = (page, id, value) =>
  page.locator(`#${id}`).evaluate((slider, to) => {
    slider.value = to;
    slider.dispatchEvent(new Event("input"));
  }, String(value));
const hit = (page, x, y) => page.evaluate(([a, b]) => window.kibori.hit(a, b), [x, y]);
const SIZE = { width: 900, height: 600 };
// Where the window shows the middle of the block.
const middleOf = (page) => page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
// Moves the pointer off the solid.
const rest = (page) => page.mouse.move(300, 30);

// Hides the hint and the notices, which come and go over the wood and are not part of the view.
async function ready(page) {
  await rest(page);
  await page.evaluate(() => (document.getElementById("messages").style.visibility = "hidden"));
}

async function begin(wood, shape = 0) {
  const studio = await Studio.start();
  const page = await open(SIZE, {
    acceptDownloads: true,
    draws: true,
    reducedMotion: "no-preference",
  });
  await enter(page, studio.url);
  await started(page);
  await page.locator(`input[name=stock][value="${shape}"]`).check();
  await page.locator("#wood").selectOption({ label: wood });
  await page.locator("#detail").selectOption("192");
  await page.locator("#go").click();
  await shown(page);
  await ready(page);
  return { studio, page };
}
async function finish({ studio, page }) {
  await page.context().close();
  check("the studio ends well", (await studio.end()) === 0);
}

async function speciesDiffer() {
  const grain = {};
  for (const wood of ["limewood", "oak", "walnut", "wax"]) {
    const visit = await begin(wood),
      { page } = visit;
    const wooden = await picture(page);
    await show(page, `look-${wood}`);
    await page.locator("#look-box > summary").click();
    await choose(page, "shading", "plain");
    await page.locator("#look-box > summary").click();
    grain[wood] = (await compare(wooden, await picture(page))).mean;
    await finish(visit);
  }
  check(`wax has less than any wood: ${JSON.stringify(grain)}`, grain.wax < 0.7 * grain.limewood);
  check(
    `limewood almost none: ${JSON.stringify(grain)}`,
    grain.limewood > 0.05 && grain.limewood < 0.35 * grain.oak,
  );
  check(
    `walnut less than oak: ${JSON.stringify(grain)}`,
    grain.walnut < grain.oak && grain.walnut > grain.limewood,
  );
}

async function shading() {
  const visit = await begin("oak"),
    { page } = visit;
  // Carve something with hollows.
  const MIDDLE = await middleOf(page);
  await page.mouse.move(MIDDLE.x - 50, MIDDLE.y - 20);
  await page.mouse.down();
  for (let i = 0; i < 20; i++) {
    await page.mouse.move(MIDDLE.x - 50 + 5 * i, MIDDLE.y - 20 + i);
    await pace(page, 30);
  }
  await page.mouse.up();
  const first = await after(page, 1);
  await rest(page);
  await page.locator("#look-box > summary").click();
  const wood = await picture(page);

  await page.locator("#hollows").uncheck();
  const open = await picture(page);
  const hollows = await compare(wood, open);
  check(
    `ambient occlusion darkens, a little: ${JSON.stringify(hollows)}`,
    hollows.signed < -0.02 && hollows.mean < 12,
  );
  await page.locator("#hollows").check();

  await page.locator("#cavity").uncheck();
  const flat = await picture(page);
  const some = await compare(wood, flat);
  await page.locator("#cavity").check();
  await slide(page, "cavity-strength", 1);
  const more = await compare(await picture(page), flat);
  check(
    `cavity shading is the stronger the more of it is wanted: ${some.mean}, ${more.mean}`,
    some.mean > 0.02 && more.mean > 1.3 * some.mean,
  );
  await slide(page, "cavity-strength", 0.5);

  await choose(page, "shading", "clay");
  let clay;
  await eventually("clay is not wood", async () => {
    clay = await picture(page);
    return (await compare(wood, clay)).mean > 4;
  });
  await show(page, "look-clay");
  const dragLight = async () => {
    const widget = await page.locator("#light").boundingBox();
    await page.mouse.move(widget.x + 28, widget.y + 28);
    await page.mouse.down();
    await page.mouse.move(widget.x + 48, widget.y + 40);
    await page.mouse.up();
    await rest(page);
  };
  await dragLight();
  check("clay's light can be dragged", (await compare(clay, await picture(page))).mean > 2);
  await choose(page, "shading", "wood");
  await dragLight();
  const lit = await picture(page);
  check("the sun can be dragged", (await compare(wood, lit)).mean > 2);
  check(
    "and says where it is",
    /from the right.*from below/.test(await page.locator("#light").getAttribute("aria-valuetext")),
  );

  // L and a drag on the wood move the light without carving.
  const before = await state(page);
  await page.locator("#view").focus();
  await page.keyboard.down("l");
  await page.mouse.move(MIDDLE.x, MIDDLE.y);
  await page.mouse.down();
  await page.mouse.move(MIDDLE.x - 110, MIDDLE.y - 60, { steps: 4 });
  await page.mouse.up();
  await page.keyboard.up("l");
  await rest(page);
  check("L + drag moves the light", (await compare(lit, await picture(page))).mean > 2);
  check(
    "and carves nothing",
    (await state(page)).volume === before.volume && before.hash === first.hash,
  );
  await page.locator("#light-reset").click();
  await rest(page);
  check("as it was", (await compare(wood, await picture(page))).mean < SAME);
  await finish(visit);
}

const unit = (v) => v.map((x) => x / Math.hypot(...v));
const minus = (a, b) => ({ x: a.x - b.x, y: a.y - b.y });
async function viewsAndSection() {
  const visit = await begin("walnut"),
    { page } = visit;
  const middle = await page.evaluate(() => window.kibori.middle()),
    MIDDLE = await middleOf(page);
  const view = async () => {
    await drawn(page);
    return unit(
      await page.evaluate(() => window.kibori.eye().map((x, i) => x - window.kibori.middle()[i])),
    );
  };
  // Two edges along x, one behind the other.
  const edges = async () => {
    await drawn(page);
    const corners = [
      [-40, -25, 15],
      [40, -25, 15],
      [-40, 25, 15],
      [40, 25, 15],
    ].map((place) => place.map((x, i) => x + middle[i]));
    const at = await page.evaluate(
      (places) => places.map((place) => window.kibori.onScreen(place)),
      corners,
    );
    const one = minus(at[1], at[0]),
      other = minus(at[3], at[2]);
    return Math.hypot(one.x - other.x, one.y - other.y);
  };
  check("in perspective what is farther is smaller", (await edges()) > 5);
  const deep = await picture(page);
  await page.keyboard.press("5");
  check("orthographic keeps lines parallel", (await edges()) < 0.01);
  check("and looks so", (await compare(deep, await picture(page))).mean > 1);
  await show(page, "look-orthographic");
  await page.keyboard.press("5");
  check("5 goes back", (await compare(deep, await picture(page))).mean < SAME);

  // The cube. A click on a visible part leads to that view.
  const away = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));
  const go = async (name, to) => {
    await drawn(page);
    await page
      .locator(`#cube button[title="${name} view"]:not([aria-hidden])`)
      .click({ force: true });
    await drawn(page);
    check(`the cube's ${name}: ${await view()}`, away(await view(), unit(to)) < 0.02);
  };
  await go("Front", [0, -1, 0]);
  await page.keyboard.press("Home");
  await go("Top", [0, 0, 1]);
  await page.keyboard.press("Home");
  await go("Top Front Left", [-1, -1, 1]);
  await go("Front Left", [-1, -1, 0]);
  // By keyboard, Tab leads to the cube, and arrows lead to the next views.
  await page.locator('#cube button[tabindex="0"]').focus();
  for (const [key, to] of [
    ["ArrowRight", [0, -1, 0]],
    ["ArrowRight", [1, -1, 0]],
    ["ArrowUp", [1, -1, 1]],
    ["ArrowUp", [0, 0, 1]],
    ["ArrowDown", [0, -1, 1]],
  ]) {
    await page.keyboard.press(key);
    await drawn(page);
    check(`${key} on the cube: ${await view()}`, away(await view(), unit(to)) < 0.02);
  }
  check(
    "the focus goes along",
    (await page.evaluate(() => document.activeElement.title)) === "Top Front view",
  );
  await page.locator("#view").focus();
  await page.keyboard.press("Home");
  await drawn(page);

  // A section. The part that is cut away is neither shown nor picked.
  const whole = await picture(page),
    surface = await hit(page, MIDDLE.x, MIDDLE.y);
  check(
    "there is a surface in the middle",
    surface.point[2] > middle[2] + 14 || surface.point[1] < middle[1] - 24,
  );
  await page.locator("#look-box > summary").click();
  await choose(page, "section", "y");
  check("the section shows", (await compare(whole, await picture(page))).share > 0.1);
  const inside = await hit(page, MIDDLE.x - 20, MIDDLE.y + 5);
  check(
    `a pick meets the cut: ${JSON.stringify(inside)}`,
    Math.abs(inside.point[1] - middle[1]) < 0.5 && inside.normal[1] < -0.99,
  );
  await show(page, "look-section");
  await slide(page, "section-at", 0.5);
  // The slider spans the wood and the room around it, where material may be added.
  const cut = await hit(page, MIDDLE.x - 20, MIDDLE.y),
    by = parseFloat(await page.locator("#section-out").textContent());
  check(
    `it can be moved by ${by} mm: ${JSON.stringify(cut)}`,
    by > 10 && Math.abs(cut.point[1] - inside.point[1] - by) < 0.2,
  );
  await page.locator("#section-flip").check();
  const kept = await hit(page, MIDDLE.x, MIDDLE.y);
  check(
    `on the other side all is as before: ${JSON.stringify(kept)}`,
    away(kept.point, surface.point) < 1e-6,
  );
  await page.locator("#section-flip").uncheck();
  await slide(page, "section-at", 0);
  await choose(page, "section", "view");
  const seen = await hit(page, MIDDLE.x, MIDDLE.y);
  check(
    "a section as seen looks at the eye",
    Math.abs(seen.normal.reduce((sum, n, i) => sum + n * unit([-0.55, -1, 0.75])[i], 0)) > 0.98,
  );
  await choose(page, "section", "off");
  check("off, all is there", (await compare(whole, await picture(page))).mean < SAME);
  await finish(visit);
}

async function reference() {
  const visit = await begin("limewood"),
    { page } = visit;
  const text = await blank.evaluate(async () => {
    const canvas = new OffscreenCanvas(64, 64),
      context = canvas.getContext("2d");
    context.fillStyle = "#00c030";
    context.fillRect(0, 0, 64, 64);
    const bytes = new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer());
    return btoa(String.fromCharCode(...bytes));
  });
  const file = join(folder, "reference.png"),
    broken = join(folder, "broken.png");
  writeFileSync(file, Buffer.from(text, "base64"));
  writeFileSync(broken, "no picture");
  const bare = await picture(page),
    places = [
      [450, 300],
      [300, 180],
      [620, 200],
    ];
  const hits = await Promise.all(places.map(([x, y]) => hit(page, x, y)));
  await page.locator("#look-box > summary").click();
  await page.locator("#reference").setInputFiles(broken);
  await until(page, "what is wrong with it", () => true);
  await page
    .locator("#notice", { hasText: "broken.png is no picture" })
    .waitFor({ state: "attached" });
  await page.locator("#reference").setInputFiles(file);
  await page.locator("#reference-remove").waitFor();
  await slide(page, "reference-size", 2.5);
  const withPicture = await picture(page);
  check("the picture shows beside the wood", (await compare(bare, withPicture)).share > 0.05);
  await show(page, "look-reference");
  const again = await Promise.all(places.map(([x, y]) => hit(page, x, y)));
  check("and takes no picks", JSON.stringify(hits) === JSON.stringify(again));
  await slide(page, "reference-deep", -1);
  check(
    "it can be brought to the front",
    (await compare(withPicture, await picture(page))).share > 0.05,
  );
  await page.locator("#reference-plane").selectOption("top");
  check("and laid under it", (await compare(withPicture, await picture(page))).share > 0.02);
  await page.locator("#reference-remove").click();
  check("removed, it is gone", (await compare(bare, await picture(page))).mean < SAME);
  await finish(visit);
}

async function picturesAndFilms() {
  const visit = await begin("oak", 1),
    { page } = visit;
  await show(page, "look-log");
  const save = async () => {
    const [download] = await Promise.all([
      page.waitForEvent("download"),
      page.locator("#capture-save").click(),
    ]);
    const to = join(folder, download.suggestedFilename());
    await download.saveAs(to);
    return to;
  };
  const corner = (path) =>
    blank.evaluate(async (text) => {
      const bitmap = await createImageBitmap(
        new Blob([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))]),
      );
      const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
      context.drawImage(bitmap, 0, 0);
      return {
        corner: [...context.getImageData(0, 0, 1, 1).data],
        middle: [...context.getImageData(bitmap.width / 2, bitmap.height / 2, 1, 1).data],
      };
    }, readFileSync(path).toString("base64"));
  await page.locator("#look-box > summary").click();
  for (const clear of [false, true]) {
    await page.locator("#picture").click();
    await page.locator("#capture-width").fill("431");
    await page.locator("#capture-height").fill("275");
    await page.locator("#capture-clear").setChecked(clear);
    const path = await save(),
      png = readFileSync(path);
    check(
      "the picture has the size that was asked for",
      png.readUInt32BE(16) === 431 && png.readUInt32BE(20) === 275,
    );
    const is = await corner(path);
    check(
      `its background: ${JSON.stringify(is)}`,
      clear ? is.corner[3] === 0 : is.corner.join() === "255,255,255,255",
    );
    check(
      `and the wood in the middle: ${JSON.stringify(is)}`,
      is.middle[3] === 255 && is.middle[0] > is.middle[2] + 20,
    );
  }
  await page.locator("#picture").click();
  await page.locator("#capture-width").fill("9");
  await page.locator("#capture-save").click();
  check(
    "a width that is none keeps the question open",
    await page.locator("#capturing").isVisible(),
  );
  await page.keyboard.press("Escape");

  await page.locator("#turn").click();
  await page.locator("#capture-width").fill("160");
  await page.locator("#capture-height").fill("120");
  await page.locator("#film-seconds").fill("1.5");
  await page.locator("#film-rate").fill("8");
  const film = readFileSync(await save());
  const about = await blank.evaluate(async (text) => {
    const video = document.createElement("video");
    video.src = URL.createObjectURL(
      new Blob([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], { type: "video/webm" }),
    );
    await new Promise((done, failed) => {
      video.onloadeddata = done;
      video.onerror = () => failed(new Error(video.error.message));
    });
    const see = async (at) => {
      const seeked = new Promise((done) => (video.onseeked = done));
      video.currentTime = at;
      await seeked;
      const context = new OffscreenCanvas(160, 120).getContext("2d");
      context.drawImage(video, 0, 0);
      return context.getImageData(0, 0, 160, 120).data;
    };
    const [one, other] = [await see(0), await see(1.1)];
    return {
      duration: video.duration,
      width: video.videoWidth,
      height: video.videoHeight,
      turned: one.reduce((sum, x, i) => sum + Math.abs(x - other[i]), 0) / one.length,
    };
  }, film.toString("base64"));
  check(
    `the film: ${JSON.stringify(about)}`,
    Math.abs(about.duration - 1.5) < 0.01 &&
      about.width === 160 &&
      about.height === 120 &&
      about.turned > 0.3,
  );
  await drawn(page);
  // If drawing is slow, the view has fewer pixels than the window, down to 0.75 of each side. Its
  // shape equals the window's.
  const size = await page.evaluate(() => [
    document.getElementById("view").width,
    document.getElementById("view").height,
  ]);
  const full = await page.evaluate(() => window.devicePixelRatio);
  const ratio = size[0] / SIZE.width;
  check(
    `afterwards the window is as it was: ${size}`,
    ratio > Math.min(0.74, full - 0.01) &&
      ratio <= full &&
      Math.abs(size[1] - ratio * SIZE.height) <= 1,
  );
  await finish(visit);
}

async function byKeyboardAlone() {
  const visit = await begin("limewood"),
    { page } = visit;
  const wood = await picture(page);
  for (
    let i = 0;
    i < 60 && (await page.evaluate(() => document.activeElement.tagName)) !== "SUMMARY";
    i++
  )
    await page.keyboard.press("Tab");
  await page.keyboard.press("Enter");
  await page.locator("#shadings").waitFor();
  await page.keyboard.press("Tab");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowRight");
  check(
    "arrows choose the shading",
    await page.locator("input[name=shading][value=clay]").isChecked(),
  );
  const difference = await compare(wood, await picture(page));
  check(`and it shows: ${JSON.stringify(difference)}`, difference.mean > 6);
  await show(page, "look-keys");
  for (let i = 0; i < 20 && (await page.evaluate(() => document.activeElement.id)) !== "light"; i++)
    await page.keyboard.press("Tab");
  const clay = await picture(page);
  for (let i = 0; i < 6; i++) await page.keyboard.press("ArrowRight");
  const chosen = await picture(page);
  check("arrows move the light", (await compare(clay, chosen)).mean > 1);

  // The choices are restored.
  await page.reload();
  await shown(page);
  await ready(page);
  check("the shading is kept", await page.locator("input[name=shading][value=clay]").isChecked());
  const again = await compare(chosen, await picture(page));
  check(`and is what is drawn, with its light: ${JSON.stringify(again)}`, again.mean < SAME);
  const frames = () => page.evaluate(() => window.kibori.frames()),
    before = await frames();
  await reports(page, 40); // two seconds or more
  check("at rest nothing is drawn", (await frames()) === before);
  await finish(visit);
}

await run([speciesDiffer, shading, viewsAndSection, reference, picturesAndFilms, byKeyboardAlone]);
