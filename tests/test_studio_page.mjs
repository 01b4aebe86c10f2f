// SPDX-License-Identifier: MIT
// The page in a real browser, from the first look to the first cut and back. Usage: node test_studio_page.mjs KIBORI [SCREENSHOT.png]
// The page's policy forbids eval, so what is waited for is asked again and again.
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [kibori, screenshot] = process.argv.slice(2);
const chromiumPath = "/usr/bin/chromium";
let chromium;
try {
  ({ chromium } = await import("../web/node_modules/playwright-core/index.mjs"));
} catch {
  // No matter why.
}
if (!chromium || !existsSync(chromiumPath)) {
  console.log("skipped: there is no Chromium, or no playwright-core; './dev setup test' installs both");
  process.exit(77);
}

const folder = mkdtempSync(join(tmpdir(), "kibori-page-"));
const studio = spawn(kibori, ["studio", join(folder, "page.kibori"), "--no-browser"]);
let said = "";
const url = await new Promise((found, failed) => {
  studio.stderr.on("data", (text) => (said += text));
  studio.stdout.on("data", (text) => {
    const address = /http:\S+/.exec(String(text));
    if (address) found(address[0]);
  });
  studio.on("exit", () => failed(new Error(`the studio ended: ${said}`)));
});
const browser = await chromium.launch({
  executablePath: chromiumPath,
  headless: true,
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});

let passed = 0;
const check = (what, holds) => {
  if (!holds) throw new Error(`not so: ${what}`);
  passed++;
};
const complaints = [];
async function open(size) {
  const page = await browser.newPage({ viewport: size });
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.message));
  return page;
}
const state = (page) => page.evaluate(() => ({ ...document.body.dataset }));
async function until(page, what, holds, seconds = 60) {
  const end = Date.now() + 1000 * seconds;
  for (;;) {
    const now = await state(page);
    if (holds(now)) return now;
    if (Date.now() > end) throw new Error(`not in ${seconds} s: ${what}; ${JSON.stringify(now)}`);
    await page.waitForTimeout(50);
  }
}

try {
  const page = await open({ width: 800, height: 500 });
  await page.goto(url);
  const first = await until(page, "the block", (s) => Number(s.chunks) > 0 && s.step === "1");
  check("the token does not stay in the address", !page.url().includes("token"));
  check("a hint says what to do", await page.locator("#hint").isVisible());

  // Another window sees the same, and only watches.
  const watcher = await open({ width: 480, height: 500 });
  await watcher.goto(url);
  await until(watcher, "the same block", (s) => s.hash === first.hash);
  check("one hand holds the tool", await watcher.locator("#take").isVisible());

  const watched = Number((await state(watcher)).chunks);
  await page.mouse.move(400, 250);
  await page.mouse.down();
  for (let i = 0; i < 12; i++) await page.mouse.move(400 + 4 * i, 250 - i);
  await until(page, "the volume falls", (s) => Number(s.volume) < Number(first.volume) - 1);
  if (screenshot) await page.screenshot({ path: screenshot });
  await page.mouse.up();
  const cut = await until(page, "a step", (s) => Number(s.step) > 1 && s.hash !== first.hash);
  await until(watcher, "the same cut", (s) => s.hash === cut.hash && Number(s.chunks) > watched);

  for (let i = 0; i < 60 && (await state(page)).step !== "1"; i++) {
    await page.keyboard.press("Control+z");
    await page.waitForTimeout(200);
  }
  const undone = await until(page, "undone", (s) => s.step === "1");
  check("undone it is bit for bit what it was", undone.hash === first.hash);
  await page.keyboard.press("Control+y");
  await until(page, "redone", (s) => Number(s.step) > 1);

  // The other takes the tool.
  await watcher.locator("#take").click();
  await page.locator("#take").waitFor({ state: "visible" });
  await watcher.locator("#take").waitFor({ state: "hidden" });

  await page.keyboard.press("?");
  check("? shows the keys", await page.locator("#keys").isVisible());
  check("the page complains of nothing: " + complaints.join("; "), complaints.length === 0);
  console.log(`${passed} checks held; the first cut removed ${(Number(first.volume) - Number(cut.volume)).toFixed(1)} mm³`);
} catch (error) {
  console.error(String(error.stack ?? error), complaints.join("\n"), said);
  process.exitCode = 1;
} finally {
  await browser.close();
  studio.removeAllListeners("exit");
  const ended = new Promise((done) => studio.on("exit", done));
  studio.kill("SIGINT");
  const status = await ended;
  if (status !== 0) {
    console.error(`the studio ended with ${status}: ${said}`);
    process.exitCode = 1;
  }
  rmSync(folder, { recursive: true, force: true });
}
