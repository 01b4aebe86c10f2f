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

/** So long a wait may last beside other work, before its test fails [s]. */
const PATIENCE = 240;

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
    timeout: 1000 * PATIENCE,
    args: [
      "--no-sandbox",
      "--use-gl=angle",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      // Each frame of a window costs SwiftShader 45 ms of a processor, if it also composites.
      "--disable-gpu-compositing",
      ...more,
    ],
  });
export const browser = await launch();

export const complaints = [];
/**
 * Contexts whose pages draw all the time. Without a graphics card a frame costs 80 ms of a
 * processor.
 */
const drawing = new WeakSet();
const quiet = (page) => !pictures && !drawing.has(page.context());
/**
 * A new window. It draws the piece only where a test waits for what it does, not during a gesture;
 * with `draws` it draws all the time. The rest of `more` is for the browser.
 */
export async function open(size, { draws = false, ...more } = {}, from = browser) {
  // Where no one looks at pictures, a quarter of the pixels is drawn. The view turns at once.
  const deviceScaleFactor = pictures ? 1 : 0.5;
  const context = await from.newContext({
    viewport: size,
    deviceScaleFactor,
    reducedMotion: "reduce",
    ...more,
  });
  context.setDefaultTimeout(1000 * PATIENCE);
  if (draws) drawing.add(context);
  else if (!pictures)
    await context.addInitScript(() => {
      let hooks;
      Object.defineProperty(window, "kibori", {
        get: () => hooks,
        set: (offered) => {
          hooks = offered;
          hooks.still(true);
        },
      });
    });
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
/** Asks until the answer holds, and returns it. `what`: a sentence, or a function that returns one. */
export async function eventually(what, ask) {
  const end = Date.now() + 1000 * PATIENCE;
  for (;;) {
    const answer = await ask();
    if (answer) return answer;
    if (Date.now() > end)
      throw new Error(`not in ${PATIENCE} s: ${typeof what === "function" ? await what() : what}`);
    await new Promise((done) => setTimeout(done, 50));
  }
}
/** The page's state, once it holds. */
export const until = (page, what, holds) =>
  eventually(
    async () =>
      `${what}; ${JSON.stringify(await state(page))}; ${await page.locator("#notice").textContent()}`,
    async () => {
      const now = await state(page);
      return holds(now) && now;
    },
  );
/**
 * Real time that belongs to a gesture: between two places of a stroke, or while a hand holds still.
 * It is for nothing else: a test that waits for the page or the studio waits for what it expects.
 */
export const pace = (page, ms) => page.waitForTimeout(ms);
/** What the page promises, if it comes in time: a page that hangs fails its test. */
async function within(what, promise) {
  let timer;
  const late = new Promise((_, fail) => {
    timer = setTimeout(() => fail(new Error(`not in ${PATIENCE} s: ${what}`)), 1000 * PATIENCE);
  });
  try {
    return await Promise.race([promise, late]);
  } finally {
    clearTimeout(timer);
  }
}
/** That many frames of the browser; after two, what the page was asked for before is drawn. */
export const frames = (page, count = 2) =>
  within(
    `${count} frames`,
    page.evaluate(async (n) => {
      for (let i = 0; i < n; i++) await new Promise((done) => requestAnimationFrame(done));
    }, count),
  );
/** That many reports of the studio's state, of which there are up to 20 a second. */
export const reports = (page, count) =>
  within(
    `${count} reports`,
    page.evaluate(async (n) => {
      for (let i = 0; i < n; i++) await window.kibori.nextState();
    }, count),
  );
/** The studio has handled all that the page has sent, and the page shows the state after it. */
export const answered = (page) =>
  within(
    "the studio answers",
    page.evaluate(() => window.kibori.answered()),
  );
/** All chunks are there. */
export const whole = (page) =>
  eventually("all of it is there", () => page.evaluate(() => window.kibori.whole()));
/**
 * The page has the surface that the studio has now. The studio sends chunks before it reports the
 * state; those that change while others are under way come with its next answer.
 */
export async function current(page) {
  await answered(page);
  await answered(page);
  await visible(page);
}
/**
 * All chunks are there, and drawn as well as can be, on a page that draws all the time. This takes
 * a second or more in software: only a test that compares pictures waits for it.
 */
export const drawn = (page) =>
  eventually("all is drawn", () =>
    page.evaluate(() => window.kibori.whole() && window.kibori.settled()),
  );
/** All chunks are there and drawn; as well as can be, where someone looks at pictures. */
export async function visible(page) {
  await whole(page);
  if (pictures) return drawn(page);
  if (quiet(page)) await page.evaluate(() => window.kibori.draw());
  await frames(page);
}
/** What the state says of `of` stays the same over `count` reports of the studio in a row. */
export async function steady(page, of = JSON.stringify, count = 4) {
  await answered(page);
  await eventually("the state rests", async () => {
    const before = of(await state(page));
    await reports(page, count);
    return before === of(await state(page));
  });
}
/**
 * Nothing goes on any more: all that was asked for is answered, several reports of the studio in a
 * row say the same, and all chunks are there. Returns the state.
 */
export async function atRest(page) {
  await steady(page);
  await visible(page);
  return state(page);
}
/** The state after `step`, once the newer step has a hash and the page has its surface. */
export async function after(page, step) {
  await until(page, "a step", (s) => Number(s.step) > Number(step) && !/^0*$/.test(s.hash));
  await current(page);
  return state(page);
}
/** Moves the pointer there without a button, until the page has drawn what it is over. */
export async function hover(page, x, y) {
  await page.mouse.move(x, y);
  await frames(page);
}
/**
 * A stroke by the pointer through these places, in `steps` moves from each to the next; the hand
 * holds still at its end [ms]. key: is held meanwhile.
 */
export async function drag(page, places, { steps = 6, hold = 100, key = null } = {}) {
  await hover(page, places[0].x, places[0].y);
  await pace(page, 200); // a hand rests before it presses; the tool that was chosen is there by then
  if (key) await page.keyboard.down(key);
  await page.mouse.down();
  for (const [i, { x, y }] of places.entries())
    if (i > 0) {
      const way = Math.hypot(x - places[i - 1].x, y - places[i - 1].y);
      await page.mouse.move(x, y, { steps: typeof steps === "function" ? steps(way) : steps });
    }
  await pace(page, hold);
  await page.mouse.up();
  if (key) await page.keyboard.up(key);
}
/** Looks along a key's direction. */
export async function lookBy(page, key) {
  await page.locator("#view").focus();
  await page.keyboard.press(key);
  await visible(page);
}
/** Presses a key until the state holds; between two presses the studio can follow. */
export const pressUntil = (page, key, what, holds) =>
  eventually(what, async () => {
    const now = await state(page);
    if (holds(now)) return now;
    await page.keyboard.press(key);
    await answered(page);
    await reports(page, 4);
  });
export const show = async (page, name) =>
  pictures && page.screenshot({ path: join(pictures, `${name}.png`) });
/** All of the piece, in its place: the view follows the panels, which grow as they are filled. */
export async function shown(page) {
  const now = await until(
    page,
    "a solid",
    (s) =>
      s.shown === "solid" && Number(s.chunks) > 0 && Number(s.volume) > 0 && Number(s.step) > 0,
  );
  await visible(page);
  const middle = () => page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
  await eventually("the piece stays in its place", async () => {
    const before = await middle();
    await reports(page, 3);
    await frames(page);
    const { x, y } = await middle();
    return x === before.x && y === before.y;
  });
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
