// SPDX-License-Identifier: MIT
// Accessibility of the page. axe finds no problem on any page, dialog and layout, light and dark.
// Keys alone do everything except carving. The focus is visible and returns. Usage: as
// test_studio.mjs
import { readFileSync } from "node:fs";
import { join } from "node:path";
import {
  check,
  enter,
  folder,
  frames,
  open,
  pace,
  pressUntil,
  run,
  show,
  shown,
  started,
  state,
  Studio,
  until,
} from "./harness.mjs";

const AXE = readFileSync(
  new URL("../../web/node_modules/axe-core/axe.min.js", import.meta.url),
  "utf8",
);
const TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"];
// The page's policy blocks other scripts, so bypass it for axe.
const BYPASS_CSP = { bypassCSP: true };

async function finds(page, where) {
  if (!(await page.evaluate(() => "axe" in window))) await page.addScriptTag({ content: AXE });
  const found = await page.evaluate(async (tags) => {
    const { violations, passes } = await window.axe.run(document, {
      runOnly: { type: "tag", values: tags },
    });
    return {
      rules: passes.length,
      wrong: violations.map(
        (v) =>
          `${v.id}: ${v.nodes.map((n) => `${n.html.slice(0, 120)} (${n.failureSummary?.split("\n")[1]?.trim()})`).join(", ")}`,
      ),
    };
  }, TAGS);
  if (found.wrong.length) await show(page, "axe");
  check(`axe finds nothing on ${where}: ${found.wrong.join("\n")}`, found.wrong.length === 0);
  check(`axe looked at ${where}`, found.rules > 10);
}

/** Presses Tab until the element has the focus. The focus must be visible at every stop. */
async function tabTo(page, selector, key = "Tab") {
  for (let i = 0; i < 120; i++) {
    await page.keyboard.press(key);
    const at = await page.evaluate((wanted) => {
      const one = document.activeElement,
        drawn = one.closest(".icons label") ?? one,
        look = getComputedStyle(drawn);
      return {
        there: one.matches(wanted),
        name: one.id || one.outerHTML.slice(0, 80),
        body: one === document.body,
        seen: look.outlineStyle !== "none" && parseFloat(look.outlineWidth) > 0,
      };
    }, selector);
    check(`the focus is seen on ${at.name}`, at.seen || at.body);
    if (at.there) return;
  }
  throw new Error(`no way to ${selector} by ${key}`);
}

async function keysAlone() {
  const studio = await Studio.start();
  const page = await open({ width: 1000, height: 700 }, BYPASS_CSP);
  await enter(page, studio.url);
  await started(page);
  // Begin a piece.
  await tabTo(page, "#detail", "Shift+Tab");
  await page.keyboard.press("ArrowUp");
  check("a coarse one", (await page.locator("#detail").inputValue()) === "192");
  await tabTo(page, "#name");
  await page.keyboard.type("by keys");
  await page.keyboard.press("Enter");
  const first = await shown(page);
  // The focus is at the piece, and the page's first stop leads there. The arrows turn the view.
  const atPiece = () => page.evaluate(() => document.activeElement.id === "view");
  check("the focus goes to the piece", await atPiece());
  await tabTo(page, ".skip", "Shift+Tab");
  check(
    "the way to the piece is shown",
    await page.locator(".skip").evaluate((link) => link.getBoundingClientRect().top >= 0),
  );
  await page.keyboard.press("Enter");
  check("it leads there", await atPiece());
  const eye = () => page.evaluate(() => window.kibori.eye());
  const far = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));
  let before = await eye();
  for (const key of [
    "ArrowLeft",
    "ArrowUp",
    "Shift+ArrowRight",
    "Shift+ArrowDown",
    "+",
    "-",
    "-",
  ]) {
    await page.keyboard.press(key);
    const now = await eye();
    check(`${key} looks otherwise`, far(now, before) > 1);
    before = now;
  }
  await page.keyboard.press("Home");
  // Choose a tool and its size.
  await tabTo(page, "#shapes input", "Shift+Tab");
  for (let i = 0; i < 2; i++) await page.keyboard.press("ArrowRight");
  check("a shape", (await page.locator("#shape-out").textContent()) === "End mill");
  await tabTo(page, "#size-typed");
  await page.keyboard.type("3");
  await page.keyboard.press("Enter");
  check("a size", (await page.locator("#size").inputValue()) === "3");
  // Cutting needs a pointer. Undo it by keys; the page announces it.
  const at = await page.evaluate(() => {
    for (let x = 300; x < 900; x += 20)
      for (let y = 100; y < 600; y += 20)
        if (
          window.kibori.onPiece(x, y) &&
          window.kibori.onPiece(x + 60, y + 20) &&
          window.kibori.onPiece(x - 40, y)
        )
          return [x, y];
  });
  await page.mouse.move(...at);
  await page.mouse.down();
  for (let i = 0; i < 10; i++) {
    await page.mouse.move(at[0] + 4 * i, at[1] + i);
    await pace(page, 50);
  }
  await page.mouse.up();
  await until(page, "a cut", (s) => Number(s.step) > 1 && s.hash !== first.hash);
  await tabTo(page, "#undo", "Shift+Tab");
  await pressUntil(page, "Enter", "undone", (s) => s.step === "1");
  await until(page, "undone", (s) => s.hash === first.hash);
  await page.locator("#announced", { hasText: /^Step 1 of/ }).waitFor({ state: "attached" });
  // The history's steps, a dialog and back, a file, and the end.
  await tabTo(page, "#history button");
  await tabTo(page, "#export", "Shift+Tab");
  await page.keyboard.press("Enter");
  check("a dialog is open", await page.locator("#exporting").isVisible());
  await page.keyboard.press("Escape");
  check(
    "Escape closes it, and the focus is back",
    await page.evaluate(
      () => !document.querySelector("dialog[open]") && document.activeElement.id === "export",
    ),
  );
  await page.keyboard.press("Enter");
  const download = page.waitForEvent("download");
  await tabTo(page, "#exporting button[value=yes]");
  await page.keyboard.press("Enter");
  check("a file is saved", (await download).suggestedFilename() === "by keys.stl");
  await tabTo(page, "#leave", "Shift+Tab");
  await page.keyboard.press("Enter");
  await started(page);
  await page.context().close();
  check("the studio ends well", (await studio.end()) === 0);
}

async function axeFindsNothing() {
  const file = join(folder, "access.kibori");
  const studio = await Studio.start();
  const page = await open({ width: 1280, height: 720 }, BYPASS_CSP);
  await enter(page, studio.url);
  await started(page);
  const both = async (where) => {
    for (const colorScheme of ["light", "dark"]) {
      await page.emulateMedia({ colorScheme });
      await finds(page, `${where}, ${colorScheme}`);
    }
  };
  await both("the first page");
  await page.setViewportSize({ width: 320, height: 480 });
  await finds(page, "the first page of a phone");
  await page.locator("#detail").selectOption("192");
  await page.locator("#go").click();
  await shown(page);
  for (const [width, height] of [
    [390, 844],
    [1024, 768],
    [1280, 720],
  ]) {
    await page.setViewportSize({ width, height });
    await frames(page);
    await both(`the piece at ${width} x ${height}`);
    for (const fold of await page.locator(width < 600 ? ".tab:visible" : ".fold:visible").all()) {
      await fold.click();
      await frames(page);
      await finds(
        page,
        `the piece at ${width} x ${height} with ${await fold.textContent()} changed`,
      );
    }
  }
  for (const fold of await page.locator(".fold[aria-expanded=false]").all()) await fold.click();
  // Panels that belong to one tool or open on request.
  await page.locator('#shapes input[aria-label="Stamp"]').check({ force: true });
  for (const what of ["0", "1"]) {
    await page.locator("#stamp-what").selectOption(what);
    await both(`a stamp of kind ${what}`);
  }
  await page.locator("#view").focus();
  await page.keyboard.press("Shift+P");
  await page.locator("#faults").waitFor();
  await both("the check before printing");
  await page.keyboard.press("Shift+P");
  // Every dialog of the page, even one without a button yet. Each fits into a small window or
  // scrolls.
  for (const id of await page.evaluate(() =>
    [...document.querySelectorAll("dialog")].map((dialog) => dialog.id),
  )) {
    for (const [width, height] of [
      [1280, 720],
      [320, 480],
    ]) {
      await page.setViewportSize({ width, height });
      await page.evaluate((which) => document.getElementById(which).showModal(), id);
      await (width > 600 ? both(`the dialog ${id}`) : finds(page, `the dialog ${id} of a phone`));
      const box = await page.locator(`#${id}`).boundingBox();
      check(
        `${id} fits into ${width} x ${height}`,
        box.x >= 0 && box.y >= 0 && box.x + box.width <= width && box.y + box.height <= height,
      );
      const cut = await page.evaluate((which) => {
        const box = document.getElementById(which).getBoundingClientRect();
        return [...document.getElementById(which).querySelectorAll("button, select, input")]
          .filter((control) => {
            control.scrollIntoView({ block: "center", inline: "center" });
            const at = control.getBoundingClientRect();
            return (
              at.width > 0 &&
              (at.bottom > box.bottom + 1 || at.top < box.top - 1 || at.right > box.right + 1)
            );
          })
          .map((control) => control.id || control.textContent);
      }, id);
      check(`all of ${id} can be reached at ${width} x ${height}: ${cut}`, cut.length === 0);
      await show(page, `dialog-${id}-${width}`);
      await page.keyboard.press("Escape");
      if (await page.locator(`#${id}`).isVisible())
        await page.evaluate((which) => document.getElementById(which).close(), id);
    }
  }
  await page.setViewportSize({ width: 1280, height: 720 });
  // The messages, and the note about watching.
  const watcher = await page.context().newPage();
  await watcher.goto(new URL(studio.url).origin);
  await watcher.locator("#watching").waitFor();
  await finds(watcher, "a window that watches");
  await watcher.close();
  await page.evaluate(() => {
    for (const id of ["hint", "work", "lost", "again"]) document.getElementById(id).hidden = false;
    document.getElementById("notice").textContent = "Something is said.";
    document.getElementById("lost-why").textContent = "The studio does not answer.";
    document.getElementById("work-what").textContent = "Reading …";
  });
  await both("messages");
  // With forced colours and reduced motion.
  await page.emulateMedia({ forcedColors: "active", reducedMotion: "reduce" });
  await show(page, "forced-colors");
  await page.context().close();
  check("the studio ends well", (await studio.end()) === 0);

  const made = await Studio.start(file);
  check("one more studio ends well", (await made.end()) === 0);
  const reader = await Studio.start(file, "--read-only");
  const looks = await open({ width: 1280, height: 720 }, BYPASS_CSP);
  await enter(looks, reader.url);
  await shown(looks);
  await finds(looks, "a document that is only looked at");
  await show(looks, "reading");
  await looks.context().close();
  check("the one that looks ends well", (await reader.end()) === 0);
}

await run([keysAlone, axeFindsNothing]);
