// SPDX-License-Identifier: MIT
// The method view: rays, dexels, vanishing points and their numbers, by hand and in an experiment.
// A page that does not show the method does not ask for it. Usage: node test_method.mjs KIBORI
// [SCREENSHOTS]
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import {
  atRest,
  check,
  enter,
  eventually,
  folder,
  frames,
  hover,
  open,
  pace,
  pictures,
  protocol,
  reports,
  run,
  show,
  shown,
  started,
  state,
  Studio,
  until,
  visible,
  inPopover,
} from "./harness.mjs";

const SIZE = { width: 1280, height: 800 };
const kindOf = (name) => protocol.messages.find((message) => message.name === name).kind;

/** Opens a page that counts its requests for the method's data, and the answers. */
async function counted() {
  const page = await open(SIZE);
  const counts = { requested: 0, answered: 0, bytes: 0 };
  page.on("websocket", (socket) => {
    socket.on(
      "framesent",
      ({ payload }) => (counts.requested += payload[0] === kindOf("AskMethod")),
    );
    socket.on("framereceived", ({ payload }) => {
      if (payload[0] !== kindOf("Method")) return;
      counts.answered++;
      counts.bytes = Math.max(counts.bytes, payload.length);
    });
  });
  return { page, counts };
}
/** The attributes of the method view, and its numbers as shown. */
const seen = (page) =>
  page.evaluate(() => {
    const box = document.querySelector("#method");
    const numbers = Object.fromEntries(
      [...box.querySelectorAll("dd")].map((dd) => [dd.id.replace("method-", ""), dd.textContent]),
    );
    return { ...box.dataset, ...numbers, visible: !box.hidden };
  });
const untilSeen = (page, what, holds) =>
  eventually(
    async () => `${what}; ${JSON.stringify(await seen(page))}`,
    async () => {
      const now = await seen(page);
      return holds(now) && now;
    },
  );

async function byHand() {
  const studio = await Studio.start();
  const { page, counts } = await counted();
  /** Waits for an answer to a later question. */
  const methodAnswered = async () => {
    const { answered } = counts;
    await eventually("an answer", () => counts.answered > answered + 1);
  };
  await enter(page, studio.url);
  await started(page);
  await page.locator("#detail").selectOption("192");
  await page.locator("#go").click();
  await shown(page);
  await page.locator("input[name=shape][value=finger]").check({ force: true });
  await inPopover(page, "#model", (one) => one.selectOption("paper"));
  await page.locator("#view").focus();
  // The middle of the block's top.
  const before = await page.evaluate(() =>
    window.kibori.onScreen(window.kibori.middle().map((x, i) => (i === 2 ? 2 * x : x))),
  );
  await hover(page, before.x, before.y);
  await atRest(page);
  check("what is not looked at is not asked for", counts.requested === 0);
  check("and not shown", !(await seen(page)).visible);

  await page.keyboard.press("m");
  const hovering = await untilSeen(page, "rays", (s) => Number(s.rays) > 100 && s.pitch !== "–");
  check(`24 x 24 rays at most (${hovering.rays})`, Number(hovering.rays) <= 25 * 25);
  check("each a dexel below the surface", Number(hovering.dexels) > 50);
  check(`the pitch is shown (${hovering.pitch})`, /^0\.417 mm, 1 ray in/.test(hovering.pitch));
  check("nothing has vanished yet", !hovering.vanished || hovering.vanished === "0");
  await reports(page, 20);
  const rested = counts.requested;
  await reports(page, 40); // two seconds or more
  check(
    `at rest it asks little (${counts.requested - rested} in 2 s)`,
    counts.requested - rested <= 12,
  );

  const first = await state(page);
  const from = counts.requested,
    began = Date.now();
  await page.mouse.down();
  for (let i = 1; i <= 30; i++) {
    await page.mouse.move(before.x + 3 * i, before.y + i);
    await pace(page, 25);
    if (i === 20) await show(page, "method-hand");
  }
  const cut = await untilSeen(page, "points that vanished", (s) => Number(s.vanished) > 20);
  await page.mouse.up();
  const rate = (1000 * (counts.requested - from)) / (Date.now() - began);
  check(`no more than 30 times a second (${rate.toFixed(1)})`, rate <= 31);
  check(
    `an answer is bounded (${counts.bytes} bytes)`,
    counts.bytes > 500 && counts.bytes < 200000,
  );
  const numbers = await untilSeen(
    page,
    "its numbers",
    (s) => Number(s.points) > 0 && s.force !== "–",
  );
  // The paper's model: |F| is Kf K.
  check(`K, |F| and the volume are shown (${JSON.stringify(numbers)})`, /N$/.test(numbers.force));
  check("the volume beside K h³", /mm³ \(K h³: [\d.e-]+\)/.test(numbers.volume));
  await until(page, "a step", (s) => Number(s.step) > Number(first.step));

  // Points that an undo removes or restores do not count as vanished, because no tick removed them.
  await atRest(page);
  await methodAnswered();
  const kept = (await seen(page)).vanished;
  await page.keyboard.press("Control+z");
  await until(page, "undone", (s) => Number(s.step) === Number(first.step));
  await page.keyboard.press("Control+y");
  await until(page, "redone", (s) => Number(s.step) > Number(first.step));
  await atRest(page);
  await methodAnswered();
  check("going back and forth is no tick", (await seen(page)).vanished === kept);
  check("points did vanish", Number(cut.vanished) > 20);

  // The panel chooses the fields, and the key switches the view off.
  await page.locator("#look-box > summary").click();
  for (const [value, name] of [
    ["0", "x"],
    ["1", "y"],
    ["2", "z"],
  ]) {
    await page.locator(`input[name=method][value="${value}"]`).check();
    await untilSeen(page, `rays of ${name}`, (s) => Number(s.rays) > 20 && s.pitch !== "–");
    check(`the field is ${name}`, (await page.locator("#method-field").textContent()) === name);
    await visible(page);
    await show(page, `method-${name}`);
  }
  // A picture leaves the method out and shows the whole solid.
  const hasPicture = await page.evaluate(() =>
    window.kibori.thumbnail().then((blob) => blob.size > 500),
  );
  check("pictures can be taken meanwhile", hasPicture);
  await page.locator("#look-box > summary").click();
  await page.locator("#view").focus();
  await page.keyboard.press("m");
  check("the key hides it", !(await seen(page)).visible);
  await atRest(page);
  const requested = counts.requested;
  await hover(page, before.x - 30, before.y);
  await atRest(page);
  check("and nothing is asked any more", counts.requested === requested);
  check("the key is listed", /method view/.test(await page.locator("#bindings").textContent()));
  await studio.end();
}

// The paper's finger makes a groove that gets deeper. It moves slowly, so that a slow machine can
// look at it before its end.
const SCENE = `
[stock]
block = [60, 30, 20]
pitch = 0.5
material = "oak"
[tool]
shape = "finger"
ks = 0.25
length = 16
[force]
model = "paper"
kf = 0.05
[motion]
rate_hz = 1000
[[move]]
to = [4, 15, 20]
axis = [0, 0, 1]
[[move]]
to = [36, 15, 12]
speed = 0.5
`;
const KF = 0.05,
  PITCH = 0.5;

async function anExperiment() {
  const studio = await Studio.start();
  const { page } = await counted();
  // Draw as with a graphics card: docs/method.png is this picture.
  if (pictures)
    await page.addInitScript(() => {
      const requested = WebGL2RenderingContext.prototype.getParameter;
      WebGL2RenderingContext.prototype.getParameter = function (name) {
        const output = requested.call(this, name);
        return typeof output === "string" && /swiftshader/i.test(output) ? "a card" : output;
      };
    });
  await enter(page, studio.url);
  await started(page);
  const file = join(folder, "groove.toml");
  writeFileSync(file, SCENE);
  await page.locator("#scene").selectOption("");
  await page.locator("#scene-file").setInputFiles(file);
  await until(page, "an experiment", (s) => s.shown === "solid" && Number(s.chunks) > 0);
  await page.locator("#view").focus();
  await page.keyboard.press("m");
  // Zoom in on the finger's path.
  const place = await page.evaluate(() => window.kibori.onScreen([31, 15, 17]));
  await page.mouse.move(place.x, place.y);
  for (let i = 0; i < 4; i++) {
    await page.mouse.wheel(0, -320);
    await frames(page);
  }
  await untilSeen(
    page,
    "points that vanish, of dexels",
    (s) => Number(s.vanished) > 300 && Number(s.points) > 0 && Number(s.dexels) > 100,
  );
  // The numbers belong to one tick: eq. (4), F = Kf K. K h³ is about the volume that the dexels
  // lost.
  for (let i = 0; i < 12; i++) {
    const now = await seen(page);
    const k = Number(now.points),
      force = parseFloat(now.force);
    check(`|F| = Kf K (${now.force}, K ${k})`, Math.abs(force - KF * k) <= 0.006 * KF * k + 1e-9);
    const [, cells] = /K h³: ([\d.e-]+)/.exec(now.volume);
    check("K h³", Math.abs(Number(cells) - k * PITCH ** 3) <= 0.006 * k * PITCH ** 3);
    await reports(page, 3);
  }
  if (pictures) {
    await page.locator("#force .fold").click();
    await page.mouse.move(1230, 700); // no ring
    const tip = async () => (await page.locator("#n-tip").textContent()).split(" ").map(Number);
    await eventually("the groove is long", async () => (await tip())[0] > 29.5);
    await show(page, "method");
  }
  await studio.end();
}

await run([byHand, anExperiment]);
