// SPDX-License-Identifier: MIT
// The page in a real browser: from the start page to the first cut and back, pen and finger, files,
// and failures. The page shows exactly the document. Usage: node test_studio.mjs KIBORI
// [SCREENSHOTS' FOLDER]
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { dirname, join } from "node:path";
import {
  after,
  atRest,
  browser,
  check,
  complaints,
  enter,
  eventually,
  folder,
  kibori,
  launch,
  open,
  pace,
  pressUntil,
  protocol,
  reports,
  run,
  show,
  shown as allShown,
  started,
  state,
  Studio,
  until,
  inPopover,
} from "./harness.mjs";

// The tests below assume that the piece is in the middle of the area right of the tools. This
// function shifts all pointer positions to the place where the piece is shown.
const moved = new WeakMap();
async function shown(page) {
  const now = await allShown(page);
  const { width, height } = page.viewportSize(),
    at = await page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
  if (!moved.has(page)) {
    const move = page.mouse.move.bind(page.mouse);
    page.mouse.move = (x, y, how) => move(x + moved.get(page).x, y + moved.get(page).y, how);
  }
  moved.set(page, { x: at.x - (230 + width) / 2, y: at.y - height / 2 });
  return now;
}
// Drives pens and fingers through one interface.
async function glass(page) {
  const session = await page.context().newCDPSession(page);
  const to = (point) => ({
    ...point,
    x: point.x + moved.get(page).x,
    y: point.y + moved.get(page).y,
  });
  return {
    send: (what, output) =>
      session.send(
        what,
        output.touchPoints ? { ...output, touchPoints: output.touchPoints.map(to) } : to(output),
      ),
  };
}

async function firstCutAndBack() {
  const studio = await Studio.start();
  const page = await open({ width: 800, height: 500 }, { draws: true });
  // Open the page as the program does, through a file with a redirect.
  const openFile = join(folder, "open.html");
  writeFileSync(
    openFile,
    `<!doctype html><meta http-equiv="refresh" content="0;url=${studio.url}">`,
  );
  await enter(page, studio.url, `file://${openFile}`);
  await started(page);
  check("the token does not stay in the address", !page.url().includes("token"));
  await show(page, "start");
  await page.locator("#detail").selectOption("192");
  await page.locator("#name").fill("page");
  await page.locator("#go").click();
  const first = await shown(page);
  check("a hint says what to do", await page.locator("#hint").isVisible());

  // Another window shows the same document and only watches.
  const watcher = await page.context().newPage();
  await watcher.goto(new URL(studio.url).origin);
  await until(watcher, "the same block", (s) => s.hash === first.hash);
  await watcher.evaluate(() => window.kibori.still(true));
  check("one hand holds the tool", await watcher.locator("#take").isVisible());

  const watched = Number((await state(watcher)).chunks);
  await page.bringToFront();
  await page.mouse.move(510, 250);
  await page.mouse.down();
  for (let i = 0; i < 12; i++) await page.mouse.move(510 + 4 * i, 250 - i);
  await until(page, "the volume falls", (s) => Number(s.volume) < Number(first.volume) - 1);
  let touched = false;
  for (let i = 0; i < 200 && !touched; i++) {
    // Move over uncut wood. A groove produces no force the second time.
    await page.mouse.move(510 + 4 * (i % 12), 250 - (i % 12) + 0.4 * i);
    touched = /[1-9]/.test(await page.locator("#n-force").textContent());
  }
  check("the force is shown", touched);
  await show(page, "cut");
  await page.mouse.up();
  const cut = await until(page, "a step", (s) => Number(s.step) > 1 && s.hash !== first.hash);
  await until(watcher, "the same cut", (s) => s.hash === cut.hash && Number(s.chunks) > watched);

  const undone = await pressUntil(page, "Control+z", "undone", (s) => s.step === "1");
  check("undone it is bit for bit what it was", undone.hash === first.hash);
  await page.keyboard.press("Control+y");
  await until(page, "redone", (s) => Number(s.step) > 1);

  // The history's cells lead to their steps, and names stay.
  await page.locator("#history .more").last().click();
  await page.locator("#version").fill("the first cut");
  await page.keyboard.press("Enter");
  await page.locator("#history .named").waitFor();
  await page.locator("#history .step").first().click();
  await until(page, "the stock again", (s) => s.step === "1" && s.hash === first.hash);

  // Assign a key to another action.
  await page.keyboard.press("?");
  check("? shows the keys", await page.locator("#keys").isVisible());
  await page.locator("#bindings button", { hasText: "Ctrl+y" }).click();
  await page.keyboard.press("r");
  await page.locator("#bindings button", { hasText: /^r$/ }).waitFor();
  await page.keyboard.press("Escape");
  await page.keyboard.press("r");
  await until(page, "redone by another key", (s) => Number(s.step) > 1);

  // The other window takes the tool.
  await watcher.bringToFront();
  await watcher.locator("#take").click();
  await watcher.locator("#take").waitFor({ state: "hidden" });
  await page.locator("#take").waitFor({ state: "visible" });
  await page.context().close();
  check("the studio ends well", (await studio.end()) === 0);
}

async function penAndFinger() {
  const studio = await Studio.start(join(folder, "hands.kibori"));
  const page = await open({ width: 700, height: 460 }, { hasTouch: true });
  await enter(page, studio.url);
  const first = await shown(page);
  // A pen that presses twice as hard removes more.
  const touch = await glass(page);
  const pen = async (force) => {
    const dispatch = (type, x, more) =>
      touch.send("Input.dispatchMouseEvent", {
        type,
        x,
        y: 250,
        button: "left",
        buttons: 1,
        pointerType: "pen",
        force,
        tiltX: 20,
        tiltY: -10,
        ...more,
      });
    await dispatch("mouseMoved", 470, { button: "none", buttons: 0, force: 0 });
    await dispatch("mousePressed", 470, { clickCount: 1 });
    for (let i = 0; i <= 20; i++) {
      await dispatch("mouseMoved", 470 + 2 * i);
      await pace(page, 30);
    }
    await pace(page, 300);
    await dispatch("mouseReleased", 510, { clickCount: 1, buttons: 0, force: 0 });
  };
  await show(page, "hands");
  const removed = [];
  for (const [pressure, axis] of [
    [0.25, "normal"],
    [0.9, "pen"],
  ]) {
    await page.locator("#axis").selectOption(axis);
    const before = await state(page);
    await pen(pressure);
    const cut = await after(page, before.step);
    removed.push(Number(before.volume) - Number(cut.volume));
    await page.keyboard.press("Control+z");
    await until(page, "undone", (s) => s.hash === first.hash);
    check("a step of the pen", Number(cut.step) > 1);
  }
  // The hand that holds the pen also rests on the screen. The view stays, and the stroke continues.
  await page.locator("#axis").selectOption("normal");
  const steady = await page.evaluate(() => window.kibori.eye());
  const resting = await state(page);
  const palm = pen(0.5);
  await pace(page, 200); // the pen's stroke has begun
  await touch.send("Input.dispatchTouchEvent", {
    type: "touchStart",
    touchPoints: [{ x: 600, y: 400 }],
  });
  await touch.send("Input.dispatchTouchEvent", {
    type: "touchMove",
    touchPoints: [{ x: 560, y: 380 }],
  });
  await palm;
  await touch.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  await until(
    page,
    "a cut beside the palm",
    (s) => Number(s.step) > Number(resting.step) && Number(s.volume) < Number(resting.volume),
  );
  check(
    "a palm does not move the view",
    Math.hypot(...(await page.evaluate(() => window.kibori.eye())).map((x, i) => x - steady[i])) <
      1e-6,
  );
  await atRest(page);
  await page.keyboard.press("Control+z");
  await until(page, "undone", (s) => s.hash === first.hash);
  check(
    `pressing harder takes more away (${removed.map((v) => v.toFixed(1)).join(" and ")} mm³)`,
    removed[1] > 1.5 * removed[0],
  );

  // A finger on the screen.
  await page.locator("#axis").selectOption("view");
  const before = await state(page);
  await touch.send("Input.dispatchTouchEvent", {
    type: "touchStart",
    touchPoints: [{ x: 470, y: 240 }],
  });
  for (let i = 0; i < 10; i++) {
    await touch.send("Input.dispatchTouchEvent", {
      type: "touchMove",
      touchPoints: [{ x: 470 + 3 * i, y: 240 }],
    });
    await pace(page, 30);
  }
  await touch.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  await until(
    page,
    "a finger's cut",
    (s) => Number(s.step) > Number(before.step) && Number(s.volume) < Number(before.volume) - 1,
  );

  // Two fingers control the view, even if the first had begun to cut.
  const whole = await atRest(page);
  const eye = await page.evaluate(() => window.kibori.eye());
  const fingers = (apart, type = "touchMove") =>
    touch.send("Input.dispatchTouchEvent", {
      type,
      touchPoints: [
        { x: 470 - apart, y: 240 },
        { x: 470 + apart, y: 240 },
      ],
    });
  await touch.send("Input.dispatchTouchEvent", {
    type: "touchStart",
    touchPoints: [{ x: 460, y: 240 }],
  });
  await pace(page, 100);
  await fingers(10, "touchStart");
  let last = eye,
    leap = 0;
  for (let i = 1; i <= 10; i++) {
    await fingers(10 + 4 * i);
    await pace(page, 30);
    const now = await page.evaluate(() => window.kibori.eye());
    leap = Math.max(leap, Math.hypot(...now.map((x, k) => x - last[k])));
    last = now;
  }
  await touch.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  check("two fingers come nearer", Math.hypot(...last) < 0.9 * Math.hypot(...eye));
  check("little by little", leap < 0.5 * Math.hypot(...eye));
  check("and cut nothing", (await atRest(page)).hash === whole.hash);
  await page.locator("#frame").evaluate((button) => button.click());

  // Touch mode cuts nothing.
  await page.locator("input[name=mode][value='touch']").check();
  const touched = await state(page);
  await page.mouse.move(470, 240);
  await page.mouse.down();
  for (let i = 0; i < 10; i++) await page.mouse.move(470 + 4 * i, 240);
  await pace(page, 800);
  await page.mouse.up();
  check("feeling cuts nothing", (await atRest(page)).hash === touched.hash);

  // Kill the studio and start it again at the same address. The page reconnects by itself, and
  // nothing is lost.
  const port = new URL(studio.url).port;
  await studio.end("SIGKILL");
  await page.locator("#lost", { hasText: "Start 'kibori studio' again" }).waitFor();
  const again = await Studio.start(join(folder, "hands.kibori"), "--port", port);
  // The key was lost with the process that gave it.
  await enter(page, again.url);
  const back = await shown(page);
  check("nothing is lost", back.hash === touched.hash && back.step === touched.step);
  await page.context().close();
  check("the studio ends well", (await again.end()) === 0);
}

// An address opens the studio in one browser only. Another browser gets a message that the terminal
// shows the next address. A browser does not send the stored key to other ports.
async function whoHasTheKey() {
  const studio = await Studio.start(join(folder, "key.kibori"));
  const page = await open({ width: 800, height: 500 });
  await enter(page, studio.url);
  await shown(page);
  await page.reload();
  await shown(page);
  await enter(page, studio.url); // from its history
  await shown(page);
  const key = await page.evaluate(() => localStorage.getItem("kibori-key"));
  check("the key is kept", /^[0-9a-f]{64}$/.test(key));
  const heard = [];
  const other = createServer((request, answer) => {
    heard.push(JSON.stringify(request.headers) + request.url);
    answer.end("<!doctype html>");
  }).listen(0, "127.0.0.1");
  await new Promise((done) => other.on("listening", done));
  const there = await page.context().newPage();
  await there.goto(`http://127.0.0.1:${other.address().port}/`);
  check(
    "another port hears and reads nothing of it",
    heard.length > 0 &&
      !heard.join().includes(key) &&
      !heard.join().toLowerCase().includes('"cookie"') &&
      (await there.evaluate(() => localStorage.length)) === 0,
  );
  other.close();

  const stranger = await open({ width: 800, height: 500 });
  const lost = stranger.locator("#lost");
  await stranger.goto(new URL(studio.url).origin);
  await lost.filter({ hasText: "This window does not have the key" }).waitFor();
  await stranger.goto(studio.url);
  await lost.filter({ hasText: "open the newest one in the terminal" }).waitFor();
  await show(stranger, "stranger");
  check(
    "and sees nothing",
    (await state(stranger)).shown === undefined && !(await stranger.url()).includes("token"),
  );
  const next = /once.*\n\s*(http:\S+)/.exec(studio.printed)[1];
  await enter(stranger, next);
  await shown(stranger);
  check("and then is in", !(await lost.isVisible()));
  await stranger.context().close();
  await page.context().close();
  check("the studio ends well", (await studio.end()) === 0);
}

// A page on a slow computer pauses for seconds, loses its connection and is reloaded. In the end it
// shows the triangles of the document's surface, which another process extracts.
async function whatIsShownIsTheModel() {
  const strokes = Number(process.env.KIBORI_STROKES ?? 300);
  const seed = Number(process.env.KIBORI_SEED ?? Date.now() % 1e9);
  const studio = await Studio.start(join(folder, "shown.kibori"));
  const watcher = await open({ width: 480, height: 360 });
  await enter(watcher, studio.url);
  await shown(watcher);
  const slow = await watcher.context().newCDPSession(watcher);
  await slow.send("Emulation.setCPUThrottlingRate", { rate: 4 });
  await watcher.evaluate(() => window.kibori.still(true));
  const hand = await watcher.context().newPage();
  await hand.goto(new URL(studio.url).origin);
  await shown(hand);
  await hand.evaluate(() => window.kibori.still(true));
  // The strokes use a separate connection.
  const carving = hand.evaluate(
    ([count, begin, version]) =>
      new Promise((done) => {
        let x = begin >>> 0 || 1;
        const random = (from, to) => {
          x ^= x << 13;
          x ^= x >>> 17;
          x ^= x << 5;
          return from + ((x >>> 0) / 2 ** 32) * (to - from);
        };
        const line = new WebSocket(`ws://${location.host}/ws`);
        line.binaryType = "arraybuffer";
        // Aim, or Press with its mode: tip, axis, time and pressure.
        const dispatch = (kind, numbers, byte) => {
          const mode = byte === undefined ? 0 : 1,
            view = new DataView(new ArrayBuffer(1 + 8 * numbers.length + mode + 16));
          view.setUint8(0, kind);
          numbers.forEach((n, i) => view.setFloat64(1 + 8 * i, n, true));
          if (mode) view.setUint8(1 + 8 * numbers.length, byte);
          view.setFloat64(1 + 8 * numbers.length + mode, performance.now() / 1000, true);
          view.setFloat64(9 + 8 * numbers.length + mode, 1, true);
          line.send(view.buffer);
        };
        line.onopen = async () => {
          const key = new TextEncoder().encode(localStorage.getItem("kibori-key"));
          line.send(new Uint8Array([1, version, 0, key.length, 0, 0, 0, ...key]));
          line.send(new Uint8Array([11]));
          for (let i = 0; i < count; i++) {
            const axis = [random(-1, 1), random(-1, 1), random(0.2, 1)];
            const at = [random(0, 80), random(0, 50), random(20, 33)],
              to = at.map((a) => a + random(-6, 6));
            const tools = window.kibori
              .tools(random(0.4, 3), random(0, 1))
              .filter(({ shape }) => shape !== "mesh");
            const tool = new TextEncoder().encode(
              JSON.stringify(tools[Math.floor(random(0, tools.length))]),
            );
            line.send(new Uint8Array([8, tool.length, 0, 0, 0, ...tool]));
            dispatch(3, [at[0], at[1], at[2] + 8, ...axis], random(0, 1) < 0.75 ? 0 : 1);
            dispatch(2, [...at, ...axis]);
            await new Promise((next) => setTimeout(next, 8));
            dispatch(2, [...to, ...axis]);
            await new Promise((next) => setTimeout(next, 12));
            line.send(new Uint8Array([4]));
            if (random(0, 1) < 0.05) line.send(new Uint8Array([6]));
          }
          setTimeout(() => done(line.close()), 500);
        };
      }),
    [strokes, seed, protocol.version],
  );
  let over = false;
  void carving.then(() => (over = true));
  for (let i = 0; !over && i < 1000; i++) {
    if (i % 3 === 0) await watcher.evaluate(() => window.kibori.breakLine());
    if (i % 3 === 1)
      await watcher.evaluate(() => {
        for (const end = performance.now() + 1500; performance.now() < end; );
      });
    if (i === 5) {
      await watcher.reload();
      await shown(watcher);
      await watcher.evaluate(() => window.kibori.still(true));
    }
    await pace(watcher, 700);
  }
  await carving;
  await slow.send("Emulation.setCPUThrottlingRate", { rate: 1 });
  const digest = async (page) => {
    const bytes = await page.evaluate(async () => {
      const sum = await crypto.subtle.digest("SHA-256", window.kibori.surface());
      return [...new Uint8Array(sum)];
    });
    return Buffer.from(bytes).toString("hex");
  };
  const settled = async (page) => {
    let last = "";
    return eventually("the surface stays the same", async () => {
      const before = last;
      await reports(page, 20);
      last = await digest(page);
      return last === before && (await page.evaluate(() => window.kibori.whole())) && last;
    });
  };
  const seen = [await settled(watcher), await settled(hand)];
  const end = await state(hand);
  check(`strokes were made (${end.step})`, Number(end.step) > strokes / 20);
  await watcher.context().close();
  check("the studio ends well", (await studio.end()) === 0);
  const chunks = execFileSync(
    join(dirname(kibori), "kibori_chunks"),
    [join(folder, "shown.kibori")],
    { maxBuffer: 1 << 29 },
  );
  const native = createHash("sha256").update(chunks).digest("hex");
  console.log(
    `  ${strokes} strokes, ${end.step} steps, ${(chunks.length / 1e6).toFixed(1)} MB of surface, KIBORI_SEED=${seed}`,
  );
  check(
    `the pages show the model's surface (${seen} and ${native}, KIBORI_SEED=${seed})`,
    seen[0] === native && seen[1] === native,
  );
}

async function mirrorsDevicesAndExperiments() {
  // X mirrors left and right. Both sides are cut, and the volume is doubled.
  const file = join(folder, "mirror.kibori");
  const studio = await Studio.start(file);
  const page = await open({ width: 1000, height: 640 });
  await enter(page, studio.url);
  const first = await shown(page);
  const cutOnce = async (before, y = 300) => {
    await page.mouse.move(510, y);
    await page.mouse.down();
    for (let i = 0; i < 10; i++) {
      await page.mouse.move(510 + 2 * i, y);
      await pace(page, 60);
    }
    await page.mouse.up();
    return until(
      page,
      "a cut",
      (s) => s.hash !== before.hash && Number(s.step) > Number(before.step),
    );
  };
  // Every tool, and a watching page sees it.
  const others = await page.context().newPage();
  await others.goto(new URL(studio.url).origin);
  await until(others, "the same block", (s) => s.hash === first.hash);
  await others.evaluate(() => window.kibori.still(true));
  await page.bringToFront();
  let last = first,
    y = 260;
  await inPopover(page, "#model", (one) => one.selectOption("energy"));
  for (const [name, form, value] of [
    ["Finger"],
    ["End mill"],
    ["Bull nose", "Corner", "3"],
    ["V cutter", "Angle", "60"],
    ["Capsule"],
    ["Box", "Breadth", "2"],
    ["Ellipsoid", "Breadth", "6"],
    ["Drill", "Point", "118"],
    ["Tapered ball nose", "Taper", "30"],
    ["Ball burr"],
  ]) {
    await page.locator(`#shapes input[aria-label="${name}"]`).check({ force: true });
    check(
      `${name} is held`,
      (await page.locator("#shape-out").textContent()) === name &&
        (await page.locator("#form").isVisible()) === Boolean(form),
    );
    if (form)
      check(`${name} has its ${form}`, (await page.locator("#form-name").textContent()) === form);
    if (form) await page.locator("#form").fill(value);
    if (name === "Finger")
      check(
        "the finger's Ks is shown",
        /Ks 0.25/.test(await page.locator("#size-out").textContent()),
      );
    last = await cutOnce(last, (y += 10));
    await until(others, `the cut of the ${name}`, (s) => s.hash === last.hash);
  }
  await others.close();
  await inPopover(page, "#model", (one) => one.selectOption("series"));
  await pressUntil(page, "Control+z", "all undone", (s) => s.step === first.step);
  await until(page, "the block again", (s) => s.hash === first.hash);
  await page.keyboard.press("x");
  check("X mirrors left and right", await page.locator("#symmetry input").first().isChecked());
  await cutOnce(first);
  const mirrored = await atRest(page);
  await show(page, "mirrored");
  const chunksOf = (which) =>
    createHash("sha256")
      .update(execFileSync(join(dirname(kibori), "kibori_chunks"), [which], { maxBuffer: 1 << 30 }))
      .digest("hex");
  const chunksBefore = chunksOf(file);
  // Another studio opens the same file read-only.
  const reader = await Studio.start(file, "--read-only");
  const looks = await open({ width: 1000, height: 640 });
  await enter(looks, reader.url);
  await until(looks, "the same", (s) => s.hash === mirrored.hash);
  check(
    "who only looks has no tools",
    (await looks.locator("#reading").isVisible()) &&
      !(await looks.locator("#shapes").isVisible()) &&
      !(await looks.locator("#force").isVisible()),
  );
  const seen = await shown(looks);
  await looks.mouse.move(510, 300);
  await looks.mouse.down();
  await looks.mouse.move(530, 330, { steps: 5 });
  await looks.mouse.up();
  await looks.locator("#undo").click();
  const back = await until(
    looks,
    "the step before",
    (s) => s.step === "1" && s.hash === first.hash,
  );
  check(
    "it changed nothing",
    seen.hash === mirrored.hash && back.hash === first.hash && chunksOf(file) === chunksBefore,
  );
  await looks.context().close();
  check("the one that looks ends well", (await reader.end()) === 0);
  check("the studio with mirrors ends well", (await studio.end()) === 0);
  execFileSync(kibori, ["verify", file]); // replay gives the same result

  // A simulated hand at a force device. It pushes only after arming.
  const held = await Studio.start("--device", "virtual", join(folder, "held.kibori"));
  await enter(page, held.url);
  await shown(page);
  check(
    "the device is named",
    /simulated hand/.test(await page.locator("#device-name").textContent()),
  );
  check(
    "it does not push by itself",
    /^Off/.test(await page.locator("#device-state").textContent()),
  );
  await page.locator("#arm").click();
  await until(page, "the hand carves", (s) => Number(s.step) > 1);
  await page.locator("#device-state", { hasText: /^On/ }).waitFor(); // armed, it pushes
  await show(page, "device");
  await page.locator("#arm").click();
  await page.locator("#device-state", { hasText: /^Off/ }).waitFor(); // disarmed, it does not
  check("the studio with a device ends well", (await held.end()) === 0);

  // Two runs of an experiment for comparison.
  const runs = await Studio.start();
  await enter(page, runs.url);
  await started(page);
  for (const model of ["energy", "series", "paper"]) {
    await page.locator("#scene").selectOption("fig8-upright");
    await page.locator("#run-model").selectOption(model);
    await page.locator("#pace").selectOption(model === "energy" ? "4" : "0");
    await page.locator("#run-form .main").click();
    if (model === "energy") {
      await until(page, "the run is shown", (s) => s.shown === "solid");
      await page.locator("#work progress").waitFor();
    }
    await page.locator("#comparing").waitFor();
    if (model === "paper") break;
    await page.locator("#comparing .close").click();
    await page.locator("#leave").click();
    await started(page);
  }
  check(
    "the runs are there",
    (await page.locator("#runs tr").count()) === 3 &&
      (await page.locator("#runs-plot canvas").count()) === 1,
  );
  await show(page, "compare");
  const [figure] = await Promise.all([
    page.waitForEvent("download"),
    page.locator("#runs-svg").click(),
  ]);
  await figure.saveAs(join(folder, "forces.svg"));
  check(
    "the figure has a line for each",
    readFileSync(join(folder, "forces.svg"), "utf8").split("<polyline").length === 4,
  );
  const [table] = await Promise.all([
    page.waitForEvent("download"),
    page.locator("#runs-csv").click(),
  ]);
  await table.saveAs(join(folder, "forces.csv"));
  const largest = [0, 0, 0];
  for (const line of readFileSync(join(folder, "forces.csv"), "utf8").trim().split("\n").slice(1)) {
    const cells = line.split(","),
      f = Math.hypot(...cells.slice(4, 7).map(Number));
    largest[Number(cells[0]) - 1] = Math.max(largest[Number(cells[0]) - 1], f);
  }
  // Compare with the command line. The scene itself uses the model paper.
  const output = execFileSync(kibori, [
    "carve",
    join(dirname(new URL(import.meta.url).pathname), "../../examples/fig8-upright.toml"),
    "--json",
  ]);
  const reported = JSON.parse(output).max_force_N;
  check(
    `the table has the forces of 'kibori carve': ${largest} and ${reported}`,
    Math.abs(largest[2] - reported) < 1e-4 * reported && largest[0] > 100 * largest[2],
  );
  // A scene without a spring is carved with a hand's strength of at most 200 N, and it removes
  // something.
  const [, removed] = /series\s+(?:[\d.,]+\s+){3}([\d.,]+)/.exec(
    await page.locator("#runs").innerText(),
  );
  check(
    `a hand of 200 N: ${largest[1]} N, ${removed} mm^3`,
    largest[1] > 150 && largest[1] < 201 && Number(removed.replace(",", "")) > 20,
  );
  await page.context().close();
  check("the studio of the runs ends well", (await runs.end()) === 0);
}

async function files() {
  const studio = await Studio.start();
  const page = await open({ width: 800, height: 600 });
  await enter(page, studio.url);
  await started(page);
  // An octahedron of 40 mm, as text.
  const corners = [
    [20, 0, 0],
    [-20, 0, 0],
    [0, 20, 0],
    [0, -20, 0],
    [0, 0, 20],
    [0, 0, -20],
  ];
  let text = "solid octahedron\n";
  for (const x of [0, 1])
    for (const y of [2, 3])
      for (const z of [4, 5]) {
        const turned = (x + y + z) % 2 === 0 ? [x, y, z] : [x, z, y];
        text += `facet normal 0 0 0\nouter loop\n${turned.map((i) => `vertex ${corners[i].join(" ")}\n`).join("")}endloop\nendfacet\n`;
      }
  const mesh = join(folder, "octahedron.stl");
  writeFileSync(mesh, `${text}endsolid octahedron\n`);
  await page.locator("#file").setInputFiles(mesh);
  await page.locator("#import-detail").selectOption("192");
  await page.locator("#importing button[value=yes]").click();
  const brought = await shown(page);
  const exact = (4 / 3) * 20 ** 3;
  check(
    `the octahedron's volume (${brought.volume} of ${exact})`,
    Math.abs(Number(brought.volume) - exact) < 0.01 * exact,
  );
  for (const format of ["stl", "3mf", "kibori"]) {
    await page.keyboard.press("Control+e");
    await page.locator("#format").selectOption(format);
    const download = page.waitForEvent("download");
    await page.locator("#exporting button[value=yes]").click();
    const file = await download;
    check("its name", file.suggestedFilename() === `octahedron.${format}`);
    await file.saveAs(join(folder, `out.${format}`));
  }
  const info = JSON.parse(execFileSync(kibori, ["info", join(folder, "out.stl"), "--json"]));
  check("what was exported is as large", Math.abs(info.volume_mm3 - exact) < 0.01 * exact);
  try {
    const judged = String(execFileSync("prusa-slicer", ["--info", join(folder, "out.stl")]));
    check("a slicer finds it closed", /manifold = yes/.test(judged));
  } catch (error) {
    if (error.code !== "ENOENT") throw error;
  }
  execFileSync(kibori, ["verify", join(folder, "out.kibori")]);
  // An invalid file is refused with a sentence, and the user can continue.
  await page.locator("#leave").click();
  await started(page);
  writeFileSync(mesh, "no mesh at all");
  await page.locator("#file").setInputFiles(mesh);
  await page
    .locator("#notice")
    .filter({ hasText: /octahedron|import|STL|mesh/ })
    .waitFor();
  await page.locator("#documents button", { hasText: "octahedron" }).first().waitFor();
  await page.locator("#documents button", { hasText: "octahedron" }).first().click();
  await shown(page);
  await page.context().close();
  check("the studio ends well", (await studio.end()) === 0);
}

// A full disk, as a separate file system. Only root can make one.
async function fullDisk() {
  const small = join(folder, "small");
  try {
    execFileSync("mkdir", ["-p", small]);
    execFileSync("mount", ["-t", "tmpfs", "-o", "size=700k", "tmpfs", small], { stdio: "ignore" });
  } catch {
    console.log("left out: a full disk, as no small file system can be mounted here");
    return;
  }
  try {
    const studio = await Studio.start(join(small, "full.kibori"));
    const page = await open({ width: 640, height: 480 });
    await enter(page, studio.url);
    const first = await shown(page);
    writeFileSync(join(small, "filler"), Buffer.alloc(1));
    try {
      for (let i = 0; i < 2000; i++) writeFileSync(join(small, `filler${i}`), Buffer.alloc(4096));
    } catch {
      // The disk is full.
    }
    for (let stroke = 0; stroke < 3; stroke++) {
      await page.mouse.move(360 + 30 * stroke, 240);
      await page.mouse.down();
      for (let i = 0; i < 14; i++) await page.mouse.move(360 + 30 * stroke + 6 * i, 240 + i);
      await pace(page, 300);
      await page.mouse.up();
    }
    await page
      .locator("#notice")
      .filter({ hasText: /full|can't be written|could not/ })
      .waitFor();
    const now = await until(
      page,
      "carved all the same",
      (s) => Number(s.volume) < Number(first.volume) - 1,
    );
    check("it goes on in memory", Number(now.step) > 1);
    // The document can be saved elsewhere, where there is space.
    await page.keyboard.press("Control+e");
    await page.locator("#format").selectOption("kibori");
    const download = page.waitForEvent("download");
    await page.locator("#exporting button[value=yes]").click();
    await (await download).saveAs(join(folder, "rescued.kibori"));
    execFileSync(kibori, ["verify", join(folder, "rescued.kibori")]);
    await page.context().close();
    const status = await studio.end();
    check(
      `the end says where the rest is (${status}; ${studio.output})`,
      status === 2 && /rescued/.test(studio.output),
    );
    const rescued = /(\/\S*rescued\S*\.kibori)/.exec(studio.output);
    if (rescued) rmSync(rescued[1], { force: true });
  } finally {
    execFileSync("umount", ["-l", small]);
  }
}

async function noWebGl() {
  const without = await launch(["--disable-gpu", "--disable-3d-apis"]);
  const studio = await Studio.start();
  const before = complaints.length;
  const page = await open({ width: 640, height: 480 }, {}, without);
  await enter(page, studio.url);
  await page.locator("#notice").filter({ hasText: "WebGL" }).waitFor();
  complaints.length = before; // errors are expected here
  check("the page says that WebGL is missing", true);
  await without.close();
  check("the studio ends well", (await studio.end()) === 0);
}

await run([
  firstCutAndBack,
  penAndFinger,
  whatIsShownIsTheModel,
  mirrorsDevicesAndExperiments,
  whoHasTheKey,
  files,
  fullDisk,
  noWebGl,
]);
