// SPDX-License-Identifier: MIT
// The palette of tools and brushes, the controls of the held tool, the fixed bar, presets and saved
// views, at three window sizes. Usage: node test_palette.mjs KIBORI [SCREENSHOTS' FOLDER]
import { readFileSync } from "node:fs";
import { join } from "node:path";
import {
  check,
  enter,
  folder,
  frames,
  inPopover,
  open,
  run,
  show,
  shown,
  Studio,
} from "./harness.mjs";

const visible = (page, ids) =>
  page.evaluate(
    (all) => all.filter((id) => document.getElementById(id).getClientRects().length > 0),
    ids,
  );
const brush = (page, mode) =>
  page.locator(`#brushes label:has(input[value=${mode}])`).evaluate((label) => label.click());
const tool = (page, shape) =>
  page.locator(`#shapes label:has(input[value=${shape}])`).evaluate((label) => label.click());
const lit = (page) =>
  page.evaluate(() => [...document.querySelectorAll("#choices .lit input")].map((i) => i.value));
const work = (page) =>
  page.evaluate(() => document.querySelector("#modes input:checked")?.value ?? null);
const value = (page, id) => page.locator(`#${id}`).inputValue();
const fill = (page, id, number) =>
  page.locator(`#${id}`).evaluate((slider, to) => {
    slider.value = String(to);
    for (const kind of ["input", "change"])
      slider.dispatchEvent(new Event(kind, { bubbles: true }));
  }, number);

async function paletteAndControls() {
  const studio = await Studio.start(join(folder, "palette.kibori"));
  const page = await open({ width: 1280, height: 720 });
  await enter(page, studio.url);
  await shown(page);
  const texts = await page.evaluate(() => document.documentElement.outerHTML.includes("{{"));
  check("every text has its words", !texts);
  for (const [width, height] of [
    [1280, 720],
    [1024, 768],
    [390, 844],
  ]) {
    await page.setViewportSize({ width, height });
    await frames(page);
    if (width < 600) await page.locator(".tab[data-panel=tools]").click();
    const where = `at ${width} x ${height}`;
    await tool(page, "ball");
    check(`a tool is lit ${where}`, (await lit(page)).join() === "ball");
    const ofTools = ["depths", "strengths", "motor", "points", "depth-below"];
    check(`its controls ${where}`, (await visible(page, ofTools)).length === ofTools.length);
    check(
      `and no others ${where}`,
      (await visible(page, ["brush", "mallet", "forms", "turns", "walls", "materials", "stamp"]))
        .length === 0,
    );
    await brush(page, "inflate");
    check(`a brush is lit ${where}`, (await lit(page)).join() === "inflate");
    check(`the work stays lit ${where}`, (await work(page)) === "cut");
    check(`the tools stay ${where}`, (await visible(page, ["shapes", "brushes"])).length === 2);
    check(`the brush's controls ${where}`, (await visible(page, ["brush"])).length === 1);
    check(`and none of tools ${where}`, (await visible(page, ofTools)).length === 0);
    await show(page, `palette-${width}x${height}`);
    await brush(page, "inflate");
    check(`the lit brush is laid down ${where}`, (await lit(page)).join() === "ball");
    await brush(page, "grab");
    await page.locator("#modes input[value=cut]").evaluate((radio) => radio.click());
    check(`work takes the tool ${where}`, (await lit(page)).join() === "ball");
    const bar = ["undo", "redo", "open-symmetry", "export", "help"];
    check(`the fixed bar is there ${where}`, (await visible(page, bar)).length === bar.length);
    const box = await page.locator("#fixed").boundingBox();
    check(`inside the window ${where}`, box.x >= 0 && box.x + box.width <= width);
    await page.locator("#open-symmetry").click();
    const pop = await page.locator("#symmetry-pop").boundingBox();
    check(
      `a popover is inside the window ${where}`,
      pop.x >= 0 && pop.y >= 0 && pop.x + pop.width <= width && pop.y + pop.height <= height,
    );
    await page.keyboard.press("Escape");
    check(`Esc closes it ${where}`, !(await page.locator("#symmetry-pop").isVisible()));
  }
  await page.setViewportSize({ width: 1280, height: 720 });
  await page.locator("#find").fill("goug");
  check(
    "the search shows what matches",
    (await page.locator("#choices label:visible").count()) === 2,
  );
  await page.locator("#find").press("Enter");
  check("Enter takes the first", (await lit(page)).join() === "gouge");
  check("and ends the search", (await page.locator("#choices label:visible").count()) > 30);
  await page.locator("#view").focus();
  await page.keyboard.press("Shift+V");
  check("a tool has a key", (await lit(page)).join() === "vee");

  // Numbers are kept for each tool and brush. The turn is not.
  await fill(page, "size", 2.5);
  await fill(page, "strength", 350);
  await brush(page, "inflate");
  await fill(page, "size", 12);
  await fill(page, "brush-strength", 80);
  await tool(page, "vee");
  check("the size of a tool", (await value(page, "size")) === "2.5");
  await page.locator("#view").focus();
  await page.keyboard.press("Shift+T");
  check("it is turned", (await value(page, "turn-by")) === "15");
  check("and says so", /15/.test(await page.locator("#at-cursor").textContent()));
  await tool(page, "box");
  check("another tool is not", (await value(page, "turn-by")) === "0");
  await tool(page, "vee");
  await page.reload();
  await shown(page);
  check("the tool is kept", (await lit(page)).join() === "vee");
  check(
    "with its numbers",
    (await value(page, "size")) === "2.5" && (await value(page, "strength")) === "350",
  );
  check("but not its turn", (await value(page, "turn-by")) === "0");
  await brush(page, "inflate");
  check(
    "and so is the brush",
    (await value(page, "size")) === "12" && (await value(page, "brush-strength")) === "80",
  );
  await page.locator("#view").focus();
  await page.keyboard.press("[");
  check(
    "a size is shown at the pointer",
    /^Size 1\d/.test(await page.locator("#at-cursor").textContent()),
  );

  // A preset is saved, exported, deleted and imported.
  await fill(page, "size", 9);
  await inPopover(page, "#preset-name", async (name) => {
    await name.fill('Big "cheeks"');
    await name.press("Enter");
  });
  const download = page.waitForEvent("download");
  await inPopover(page, "#preset-export", (button) => button.click());
  const file = await (await download).path();
  const toml = readFileSync(file, "utf8");
  check(
    `a preset is TOML: ${toml}`,
    toml.startsWith('[[preset]]\nname = "Big \\"cheeks\\""\nbrush = "inflate"\nsize = 9\n'),
  );
  await inPopover(page, "#preset-list button:last-child", (button) => button.click());
  check("it is deleted", (await page.locator("#preset-list li").count()) === 0);
  const bring = (text) =>
    page
      .locator("#preset-import")
      .setInputFiles({ name: "my.toml", mimeType: "text/plain", buffer: Buffer.from(text) });
  await bring("[[preset]]\nname = 3x\n");
  await page.locator("#notice", { hasText: "my.toml, line 2" }).waitFor();
  await tool(page, "ball");
  await bring(toml);
  await page.locator("#notice", { hasText: "Imported presets: 1" }).waitFor();
  await inPopover(page, "#preset-list button", (button) => button.click());
  check(
    "and taken again",
    (await lit(page)).join() === "inflate" && (await value(page, "size")) === "9",
  );

  // The keys that are held during a drag (anywhere, light) choose nothing.
  await page.locator("#view").focus();
  for (const key of ["b", "l"]) {
    await page.keyboard.press(key);
    check(`${key} chooses nothing`, (await lit(page)).join() === "inflate");
  }

  // Saved views.
  const eye = () =>
    page.evaluate(() =>
      window.kibori
        .eye()
        .map((x) => x.toFixed(3))
        .join(),
    );
  await page.locator("#view").focus();
  await page.keyboard.press("1");
  const front = await eye();
  await page.keyboard.press("8");
  await page.keyboard.press("7");
  check("another view", (await eye()) !== front);
  await page.keyboard.press("9");
  check("the saved view", (await eye()) === front);
  await page.context().close();
  check("the studio ends well", (await studio.end()) === 0);
}

await run([paletteAndControls]);
