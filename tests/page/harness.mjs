// SPDX-License-Identifier: MIT
// What tests of the page in a real browser share: a studio as a process of its own, Chromium, and
// ways to wait. A test calls run(parts): each part is a function whose name KIBORI_PART chooses.
// The program's arguments are KIBORI [SCREENSHOTS' FOLDER]. The page's policy forbids eval, so what
// is waited for is asked again and again.
import { execFileSync, spawn } from "node:child_process";
import { chmodSync, existsSync, mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

export const [kibori, pictures] = process.argv.slice(2);
const chromiumPath = "/usr/bin/chromium";
let chromium;
try {
  ({ chromium } = await import("../../web/node_modules/playwright-core/index.mjs"));
} catch {
  // No matter why.
}
if (!chromium || !existsSync(chromiumPath)) {
  console.log(
    "skipped: there is no Chromium, or no playwright-core; './dev setup test' installs both",
  );
  process.exit(77);
}

export const protocol = JSON.parse(
  readFileSync(new URL("../../protocol/messages.json", import.meta.url), "utf8"),
);
export const folder = mkdtempSync(join(tmpdir(), "kibori-page-"));
let passed = 0;
export const check = (what, holds) => {
  if (!holds) throw new Error(`not so: ${what}`);
  passed++;
};

const studios = [];
export class Studio {
  said = "";
  printed = "";
  static async start(...words) {
    const studio = new Studio();
    studios.push(studio);
    studio.process = spawn(kibori, ["studio", "--no-browser", ...words], {
      env: { ...process.env, XDG_DATA_HOME: folder },
    });
    studio.ended = new Promise((done) =>
      studio.process.on("exit", (code, signal) => done(code ?? signal)),
    );
    studio.url = await new Promise((found, failed) => {
      studio.process.stderr.on("data", (text) => (studio.said += text));
      studio.process.stdout.on("data", (text) => {
        studio.printed += text;
        const address = /http:\S+/.exec(String(text));
        if (address) found(address[0]);
      });
      studio.process.on("exit", () => failed(new Error(`the studio ended: ${studio.said}`)));
    });
    return studio;
  }
  /**
   * The address for another browser, which the studio prints when one asks by the address that was
   * used.
   */
  async another() {
    const used = new URL(this.url),
      before = this.printed.length;
    await fetch(`${used.origin}/enter?token=${used.searchParams.get("token")}`, {
      method: "POST",
      headers: { Origin: used.origin },
    });
    for (;;) {
      const next = /http:\S+\n/.exec(this.printed.slice(before));
      if (next) return (this.url = next[0].trim());
      await new Promise((done) => setTimeout(done, 20));
    }
  }
  async end(how = "SIGINT") {
    this.process.kill(how);
    return this.ended;
  }
}

export const launch = (more = []) =>
  chromium.launch({
    executablePath: chromiumPath,
    headless: true,
    args: [
      "--no-sandbox",
      "--use-gl=angle",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      ...more,
    ],
  });
export const browser = await launch();

export const complaints = [];
export async function open(size, more = {}, from = browser) {
  // Where no one looks at pictures, a quarter of the pixels is drawn.
  const deviceScaleFactor = pictures ? 1 : 0.5;
  const context = await from.newContext({ viewport: size, deviceScaleFactor, ...more });
  context.setDefaultTimeout(120000); // two tests on two cores, without a graphics card
  const page = await context.newPage();
  page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.message));
  return page;
}
// With the token, which then gives way to the page.
export async function enter(page, url, from = url) {
  await page.goto(from);
  await page.waitForURL(`${new URL(url).origin}/`);
}
/** The bytes of what the studio answers to the page's key. */
export async function fetched(page, path) {
  // As text: numbers one by one take a minute for a few MB.
  const url = await page.evaluate(async (asked) => {
    const answer = await fetch(asked, {
      headers: { Authorization: `Bearer ${localStorage.getItem("kibori-key")}` },
    });
    const reader = new FileReader();
    const read = new Promise((done) => (reader.onload = done));
    reader.readAsDataURL(await answer.blob());
    await read;
    return reader.result;
  }, path);
  return Buffer.from(url.slice(url.indexOf(",") + 1), "base64");
}
/** The document that was begun last. */
export const newest = () =>
  join(
    folder,
    "kibori",
    readdirSync(join(folder, "kibori"))
      .filter((name) => name.endsWith(".kibori"))
      .sort()
      .at(-1),
  );
/** It is carved again by the command line, step by step, to the same hashes. */
export const verified = () =>
  /all is as it was written/.test(execFileSync(kibori, ["verify", newest()], { encoding: "utf8" }));
export const state = (page) => page.evaluate(() => ({ ...document.body.dataset }));
export async function until(page, what, holds, seconds = 60) {
  const end = Date.now() + 1000 * seconds;
  for (;;) {
    const now = await state(page);
    if (holds(now)) return now;
    if (Date.now() > end)
      throw new Error(
        `not in ${seconds} s: ${what}; ${JSON.stringify(now)}; ${await page.locator("#notice").textContent()}`,
      );
    await page.waitForTimeout(50);
  }
}
export const show = async (page, name) =>
  pictures && page.screenshot({ path: join(pictures, `${name}.png`) });
// All of it: before, the view is not where the pointer thinks.
export async function shown(page) {
  const now = await until(
    page,
    "a solid",
    (s) =>
      s.shown === "solid" && Number(s.chunks) > 0 && Number(s.volume) > 0 && Number(s.step) > 0,
  );
  for (let i = 0; i < 600 && !(await page.evaluate(() => window.kibori.whole())); i++)
    await page.waitForTimeout(100);
  await page.waitForTimeout(300);
  return now;
}
export const started = (page) =>
  until(page, "the choice to begin with", (s) => s.shown === "start");

/**
 * Runs the parts one after another, and ends the process: 0 if every check held and the page
 * complained of nothing.
 */
export async function run(parts) {
  try {
    const only = process.env.KIBORI_PART;
    for (const part of parts) {
      if (only && part.name !== only) continue;
      const from = Date.now();
      await part();
      console.log(`${part.name}: ${((Date.now() - from) / 1000).toFixed(1)} s`);
    }
    // A line that breaks is no fault of the page, nor is a file that the studio refuses.
    const faults = complaints.filter((text) => !/WebSocket|ERR_CONNECTION|403|415|422/.test(text));
    check(`the page complains of nothing: ${faults.join("; ")}`, faults.length === 0);
    console.log(`${passed} checks held`);
  } catch (error) {
    console.error(String(error.stack ?? error), complaints.join("\n"));
    process.exitCode = 1;
  } finally {
    await browser.close();
    for (const { process: left } of studios) if (left.exitCode === null) left.kill("SIGKILL"); // of a check that failed
    chmodSync(folder, 0o700);
    rmSync(folder, { recursive: true, force: true });
  }
  process.exit();
}
