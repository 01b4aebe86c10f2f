// SPDX-License-Identifier: MIT
// Helpers for tests of the page in a real browser: a studio as a separate process, Chromium, and
// functions that wait. A test calls run(parts). Each part is a function, and KIBORI_PART can choose
// one by name. The program's arguments are KIBORI [SCREENSHOTS' FOLDER]. The page's policy forbids
// eval, so waiting means asking repeatedly.
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
  // The check below reports that playwright-core is missing.
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

/** A test fails if a wait takes longer than this [s]. It is long enough for a busy machine. */
const PATIENCE = 240;

const studios = [];
export class Studio {
  output = "";
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
      studio.process.stderr.on("data", (text) => (studio.output += text));
      studio.process.stdout.on("data", (text) => {
        studio.printed += text;
        const address = /http:\S+/.exec(String(text));
        if (address) found(address[0]);
      });
      studio.process.on("exit", () => failed(new Error(`the studio ended: ${studio.output}`)));
    });
    return studio;
  }
  /**
   * Returns the address for another browser. The studio prints it when a browser sends a token that
   * was used already.
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
      // If SwiftShader also composites the window, each frame takes 45 ms more of processor time.
      "--disable-gpu-compositing",
      ...more,
    ],
  });
export const browser = await launch();

export const complaints = [];
/**
 * Contexts whose pages always draw. Without a graphics card a frame costs 80 ms of processor time.
 */
const drawing = new WeakSet();
const quiet = (page) => !pictures && !drawing.has(page.context());
/**
 * Opens a new window. It draws the piece only while a test waits for a result, not during a
 * gesture. With `draws` it always draws. The rest of `more` is for the browser.
 */
export async function open(size, { draws = false, ...more } = {}, from = browser) {
  // If no pictures are taken, draw a quarter of the pixels. The view turns at once.
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
// Enters with the token. The page then removes it from the address.
export async function enter(page, url, from = url) {
  await page.goto(from);
  await page.waitForURL(`${new URL(url).origin}/`);
}
/** The bytes of the studio's answer to a request with the page's key. */
export async function fetched(page, path) {
  // Transfer as text. An array of numbers takes a minute for a few MB.
  const url = await page.evaluate(async (address) => {
    const answer = await fetch(address, {
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
/** The newest document. */
export const newest = () =>
  join(
    folder,
    "kibori",
    readdirSync(join(folder, "kibori"))
      .filter((name) => name.endsWith(".kibori"))
      .sort()
      .at(-1),
  );
/** The command line replays the document step by step to the same hashes. */
export const verified = () =>
  /steps, .*no differences/.test(execFileSync(kibori, ["verify", newest()], { encoding: "utf8" }));
export const state = (page) => page.evaluate(() => ({ ...document.body.dataset }));
/**
 * Asks until the answer is truthy, and returns it. `what`: a sentence, or a function that returns
 * one.
 */
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
/** Waits until the page's state satisfies `holds`. Returns the state. */
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
 * Real time that belongs to a gesture: between two positions of a stroke, or while a hand holds
 * still. Do not use it for anything else. A test that waits for the page or the studio waits for
 * the expected result.
 */
export const pace = (page, ms) => page.waitForTimeout(ms);
/** Waits for a promise of the page with a time limit. A page that hangs fails its test. */
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
/** Waits for a number of browser frames. After two, everything requested before is drawn. */
export const frames = (page, count = 2) =>
  within(
    `${count} frames`,
    page.evaluate(async (n) => {
      for (let i = 0; i < n; i++) await new Promise((done) => requestAnimationFrame(done));
    }, count),
  );
/** Waits for a number of the studio's state reports, of which there are up to 20 per second. */
export const reports = (page, count) =>
  within(
    `${count} reports`,
    page.evaluate(async (n) => {
      for (let i = 0; i < n; i++) await window.kibori.nextState();
    }, count),
  );
/**
 * Waits until the studio has handled all messages of the page, and the page shows the state after
 * them.
 */
export const answered = (page) =>
  within(
    "the studio answers",
    page.evaluate(() => window.kibori.answered()),
  );
/** Waits until all chunks have arrived. */
export const whole = (page) =>
  eventually("all of it is there", () => page.evaluate(() => window.kibori.whole()));
/**
 * Waits until the page has the studio's current surface. The studio sends chunks before it reports
 * the state. Chunks that change while others are in transit come with its next answer.
 */
export async function current(page) {
  await answered(page);
  await answered(page);
  await visible(page);
}
/**
 * Waits until all chunks have arrived and are drawn at full quality, on a page that always draws.
 * This takes a second or more in software. Only tests that compare pictures wait for it.
 */
export const drawn = (page) =>
  eventually("all is drawn", () =>
    page.evaluate(() => window.kibori.whole() && window.kibori.settled()),
  );
/** Waits until all chunks have arrived and are drawn, at full quality if pictures are taken. */
export async function visible(page) {
  await whole(page);
  if (pictures) return drawn(page);
  if (quiet(page)) await page.evaluate(() => window.kibori.draw());
  await frames(page);
}
/** Waits until `of` the state is the same in `count` consecutive reports. */
export async function steady(page, of = JSON.stringify, count = 4) {
  await answered(page);
  await eventually("the state rests", async () => {
    const before = of(await state(page));
    await reports(page, count);
    return before === of(await state(page));
  });
}
/**
 * Waits until nothing changes: all requests are answered, several consecutive reports are equal,
 * and all chunks have arrived. Returns the state.
 */
export async function atRest(page) {
  await steady(page);
  await visible(page);
  return state(page);
}
/** Waits for a step newer than `step` with a hash and its surface. Returns the state. */
export async function after(page, step) {
  await until(page, "a step", (s) => Number(s.step) > Number(step) && !/^0*$/.test(s.hash));
  await current(page);
  return state(page);
}
/** Moves the pointer without a button and waits until the page has drawn what is under it. */
export async function hover(page, x, y) {
  await page.mouse.move(x, y);
  await frames(page);
}
/**
 * A pointer stroke through these positions, in `steps` moves from each to the next. The hand holds
 * still at its end [ms]. `key` is held down meanwhile.
 */
export async function drag(page, places, { steps = 6, hold = 100, key = null } = {}) {
  await hover(page, places[0].x, places[0].y);
  await pace(page, 200); // a hand rests before it presses; the chosen tool is active by then
  if (key) await page.keyboard.down(key);
  await page.mouse.down();
  for (const [i, { x, y }] of places.entries())
    if (i > 0) {
      const distance = Math.hypot(x - places[i - 1].x, y - places[i - 1].y);
      await page.mouse.move(x, y, { steps: typeof steps === "function" ? steps(distance) : steps });
    }
  await pace(page, hold);
  await page.mouse.up();
  if (key) await page.keyboard.up(key);
}
/** Uses a control of a popover: opens the popover, calls `use` with the control, and closes it. */
export async function inPopover(page, control, use) {
  const one = page.locator(control).first();
  await one.evaluate((element) => {
    const popover = element.closest("[popover]");
    if (!popover.matches(":popover-open")) popover.showPopover();
  });
  await use(one);
  // Closes the popover without its control, which may have disappeared.
  await page.evaluate(() => document.querySelector("[popover]:popover-open")?.hidePopover());
}
/** Looks along the direction of a key. */
export async function lookBy(page, key) {
  await page.locator("#view").focus();
  await page.keyboard.press(key);
  await visible(page);
}
/** Presses a key until the state satisfies `holds`. The studio can follow between two presses. */
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
/**
 * Waits until the whole piece is shown in its place. The view follows the panels, which grow as
 * they are filled.
 */
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
 * Runs the parts one after another and ends the process. The status is 0 if every check passed and
 * the page reported no errors.
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
    // A broken connection and a file that the studio refuses are not the page's errors.
    const faults = complaints.filter(
      (text) => !/WebSocket|ERR_CONNECTION|ERR_EMPTY_RESPONSE|403|415|422/.test(text),
    );
    check(`the page complains of nothing: ${faults.join("; ")}`, faults.length === 0);
    console.log(`${passed} checks held`);
  } catch (error) {
    console.error(String(error.stack ?? error), complaints.join("\n"));
    process.exitCode = 1;
  } finally {
    await browser.close();
    // After a failed check, studios are still running.
    for (const { process: left } of studios) if (left.exitCode === null) left.kill("SIGKILL");
    chmodSync(folder, 0o700);
    rmSync(folder, { recursive: true, force: true });
  }
  process.exit();
}
