// SPDX-License-Identifier: MIT
// The page's layout. At every size nothing covers anything else, everything is reachable, and the
// piece fits in the free area. Also the sheet of narrow windows by touch, typed numbers, stored
// values, and the connection to a studio that ends. Usage: node test_layout.mjs KIBORI
// [SCREENSHOTS' FOLDER]
import { join } from "node:path";
import {
  check,
  drawn as allDrawn,
  enter,
  eventually,
  folder,
  frames,
  open,
  pace,
  pictures,
  run,
  show,
  shown,
  started,
  state,
  Studio,
  until,
} from "./harness.mjs";

const SIZES = [
  [320, 480],
  [390, 844],
  [599, 480],
  [640, 480],
  [800, 500],
  [1024, 768],
  [1280, 720],
  [1920, 1080],
];
const PANELS = ["tools", "force", "past"];
const PARTS = [
  "bar",
  "grip",
  "fixed",
  ...PANELS,
  "corner",
  "watching",
  "lost",
  "work",
  "notice",
  "hint",
];
// Switches drawing on or off. Only pictures for people need it.
const draw = (page, drawn) => page.evaluate((still) => window.kibori.still(still), !drawn);
// Waits until the page has done its layout and has measured it.
const afterLayout = frames;
const narrow = (page) => page.viewportSize().width < 600;

// The names of visible parts that cover each other or extend out of the window.
const overlaps = (page) =>
  page.evaluate((parts) => {
    // Messages that are scrolled out of view cover nothing.
    const view = document.getElementById("messages").getBoundingClientRect();
    const shown = (part) => {
      const { left, right, top, bottom, width, height } = part.getBoundingClientRect();
      if (width === 0 || height === 0 || !part.closest("#messages"))
        return { left, right, top, bottom, width, height };
      return {
        left,
        right,
        top: Math.max(top, view.top),
        bottom: Math.min(bottom, view.bottom),
        width,
        height: Math.min(bottom, view.bottom) - Math.max(top, view.top),
      };
    };
    const boxes = parts
      .map((id) => ({ id, box: shown(document.getElementById(id)) }))
      .filter(({ box }) => box.width > 0 && box.height > 0);
    const wrong = boxes
      .filter(
        ({ box }) =>
          box.left < 0 ||
          box.top < 0 ||
          box.right > innerWidth + 0.5 ||
          box.bottom > innerHeight + 0.5,
      )
      .map(({ id }) => `${id} reaches out`);
    boxes.forEach((a, i) => {
      for (const b of boxes.slice(i + 1))
        if (
          a.box.left < b.box.right - 0.5 &&
          b.box.left < a.box.right - 0.5 &&
          a.box.top < b.box.bottom - 0.5 &&
          b.box.top < a.box.bottom - 0.5
        )
          wrong.push(`${a.id} and ${b.id}`);
    });
    return wrong;
  }, PARTS);

// Visible controls that cannot be brought to where a press reaches them.
const unreachable = (page) =>
  page.evaluate((panels) => {
    const wrong = [];
    for (const id of ["bar", "grip", "fixed", "messages", ...panels])
      for (const control of document
        .getElementById(id)
        .querySelectorAll("button, select, input:not(.unseen)")) {
        const target = control.closest(".icons label") ?? control;
        if (target.getClientRects().length === 0) continue;
        target.scrollIntoView({ block: "center", inline: "center" });
        const box = target.getBoundingClientRect(),
          met = document.elementFromPoint(box.left + box.width / 2, box.top + box.height / 2);
        if (!met || !(target.contains(met) || met.contains(target)))
          wrong.push(`${id}: ${control.id || control.textContent || control.outerHTML}`);
      }
    return wrong;
  }, PANELS);

// isOpen() returns whether a panel is open. turn() opens or closes it by a press.
const isOpen = async (page, id) =>
  (await page.locator(`#${id}`).getAttribute("class")).includes("folded") === false;
async function turn(page, id, open) {
  if ((await isOpen(page, id)) !== open)
    await page.locator(narrow(page) ? `.tab[data-panel=${id}]` : `#${id} .fold`).click();
  check(`${id} is ${open ? "open" : "folded"}`, (await isOpen(page, id)) === open);
}

async function nothingCoversAnything() {
  const studio = await Studio.start(join(folder, "layout.kibori"));
  const page = await open({ width: 1280, height: 720 });
  await enter(page, studio.url);
  await shown(page);
  await draw(page, false);
  const states = {
    carved: () => {},
    messages: () => {
      for (const id of ["hint", "watching", "work", "lost"])
        document.getElementById(id).hidden = false;
      document.getElementById("again").hidden = false;
      document.getElementById("work-what").textContent =
        "Reading a mesh with a rather long name.stl …";
      document.getElementById("lost-why").textContent =
        "The studio does not answer: it has ended. Start 'kibori studio' again.";
      document.getElementById("notice").textContent =
        "The wood holds the tool back with 3.2 N. Take less depth, or a smaller tool.";
    },
    device: () => {
      document.body.classList.add("device");
      document.getElementById("device").hidden = false;
      document.getElementById("device-name").textContent = "simulated hand: at most 12 N";
    },
    reading: () => {
      document.body.classList.remove("device");
      document.body.classList.add("read-only");
    },
    experiment: () => document.body.classList.add("experiment"),
    again: () => {
      document.body.classList.remove("read-only", "experiment");
      for (const id of ["hint", "watching", "work", "lost", "device"])
        document.getElementById(id).hidden = true;
      document.getElementById("notice").textContent = "";
    },
  };
  for (const [width, height] of SIZES) {
    await page.setViewportSize({ width, height });
    await afterLayout(page);
    for (const [name, make] of Object.entries(states)) {
      await page.evaluate(make);
      for (const opened of narrow(page) ? [...PANELS, ""] : ["all", ""]) {
        const there = [];
        for (const id of PANELS)
          if (
            await page.evaluate(
              (i) => getComputedStyle(document.getElementById(i)).display !== "none",
              id,
            )
          )
            there.push(id);
        if (narrow(page)) {
          if (
            opened &&
            !(name === "experiment" && opened === "past") &&
            !(name === "reading" && opened === "force")
          )
            await turn(page, opened, true);
          if (!opened)
            for (const id of PANELS)
              if (await isOpen(page, id)) await page.locator("#handle").press("Enter");
        } else {
          for (const id of there) await turn(page, id, opened === "all");
        }
        const where = `at ${width} x ${height}, ${name}, ${opened || "folded"}`;
        const wrong = await overlaps(page);
        if (wrong.length) await show(page, "overlap");
        check(`nothing covers anything ${where}: ${wrong.join("; ")}`, wrong.length === 0);
        const lost = await unreachable(page);
        if (lost.length) await show(page, "unreachable");
        check(`all can be reached ${where}: ${lost.join("; ")}`, lost.length === 0);
      }
    }
    // The piece is in the middle of the free area, and no panel covers it.
    for (const id of PANELS) await turn(page, id, narrow(page) ? id === "past" : id !== "force");
    await afterLayout(page);
    await page.locator("#frame").evaluate((button) => button.click());
    if (pictures) {
      await draw(page, true);
      await allDrawn(page);
      await show(page, `layout-${width}x${height}`);
      await draw(page, false);
    }
    const behind = await page.evaluate(
      (parts) => {
        const hits = [];
        for (const id of parts) {
          const box = document.getElementById(id).getBoundingClientRect();
          for (let x = box.left + 2; x < box.right; x += 17)
            for (let y = box.top + 2; y < box.bottom; y += 17)
              if (window.kibori.onPiece(x, y)) hits.push(id);
        }
        return [...new Set(hits)];
      },
      ["bar", "grip", "fixed", ...PANELS],
    );
    check(
      `the piece is in what is free at ${width} x ${height}, not behind ${behind}`,
      behind.length === 0,
    );
  }
  // A folded panel stays folded.
  await turn(page, "tools", false);
  await page.reload();
  await shown(page);
  check(
    "panels are as they were",
    !(await isOpen(page, "tools")) &&
      (await isOpen(page, "past")) &&
      !(await isOpen(page, "force")),
  );
  await page.context().close();
  check("the studio ends well", (await studio.end()) === 0);
}

async function sheetByTouch() {
  const studio = await Studio.start(join(folder, "phone.kibori"));
  const page = await open({ width: 390, height: 844 }, { hasTouch: true, isMobile: true });
  await enter(page, studio.url);
  const first = await shown(page);
  await draw(page, false);
  const finger = await page.context().newCDPSession(page);
  const touch = (type, x, y) =>
    finger.send("Input.dispatchTouchEvent", {
      type,
      touchPoints: type === "touchEnd" ? [] : [{ x, y }],
    });
  const drag = async (x, y, toX, toY) => {
    await touch("touchStart", x, y);
    for (let i = 1; i <= 12; i++) {
      await touch("touchMove", x + ((toX - x) * i) / 12, y + ((toY - y) * i) / 12);
      await pace(page, 30);
    }
    await touch("touchEnd");
    await frames(page);
  };
  const top = async () => (await page.locator("#grip").boundingBox()).y;
  check(
    "the tool and its size are announced",
    /Ball burr\s*4 mm/.test(await page.locator(".tab[data-panel=tools]").textContent()),
  );
  const closed = await top();
  check("closed, the sheet leaves most to the piece", closed > 0.85 * 844);
  await drag(195, closed + 8, 195, closed - 250);
  const drawn = await top();
  check(
    `drawn by its handle, it opens (${closed}, ${drawn})`,
    Math.abs(closed - 250 - drawn) < 40 && (await page.locator("#size-typed").isVisible()),
  );
  for (const id of PANELS) {
    await page.locator(`.tab[data-panel=${id}]`).tap();
    if (!(await isOpen(page, id))) await page.locator(`.tab[data-panel=${id}]`).tap();
    await frames(page);
    await show(page, `phone-${id}`);
    const small = await page.evaluate(() =>
      [
        ...document.querySelectorAll(
          "#carving :is(button, select, input:not(.unseen)), .u-legend [role=button]",
        ),
      ]
        .map(
          (control) =>
            control.closest(
              "#modes label, #symmetry label, .icons label, #motor, #mallet label, #keeps",
            ) ?? control,
        )
        .filter(
          (target) =>
            target.getClientRects().length > 0 &&
            (target.getBoundingClientRect().height < 43.5 ||
              target.getBoundingClientRect().width < 43.5),
        )
        .map(
          (target) =>
            `${target.id || target.textContent} ${target.getBoundingClientRect().width} x ${target.getBoundingClientRect().height}`,
        ),
    );
    check(`a finger meets all of ${id}: ${small.join("; ")}`, small.length === 0);
  }
  // The sheet scrolls under a finger.
  await page.locator(".tab[data-panel=tools]").tap();
  await drag(195, 760, 195, 560);
  check(
    "the sheet scrolls",
    (await page.locator("#tools").evaluate((panel) => panel.scrollTop)) > 50,
  );
  const now = await top();
  await drag(195, now + 8, 195, 830);
  check("drawn down, it closes", (await top()) > 0.85 * 844);
  // Above the sheet the finger carves.
  const at = await page.evaluate(() => {
    for (let y = 200; y < 700; y += 10)
      if (window.kibori.onPiece(195, y) && window.kibori.onPiece(195, y + 40)) return y + 20;
    return 0;
  });
  check("the piece is there", at > 0);
  await drag(180, at, 220, at);
  await until(
    page,
    "a finger's cut",
    (s) => Number(s.step) > Number(first.step) && Number(s.volume) < Number(first.volume),
  );
  await page.locator("#undo").tap();
  await until(page, "undone", (s) => s.hash === first.hash);
  await page.context().close();
  check("the studio ends well", (await studio.end()) === 0);
}

async function numbersAndWhatIsKept() {
  const studio = await Studio.start();
  const page = await open({ width: 1000, height: 700 });
  await enter(page, studio.url);
  await started(page);
  await page.locator("#wood").selectOption({ label: "walnut" });
  await page.locator("#detail").selectOption("192");
  await page.locator("#length").fill("120");
  await page.locator("#go").click();
  await shown(page);
  const adds = () => page.locator("#material option:checked").textContent();
  check("what is added is the piece's own wood", (await adds()) === "walnut");

  const typed = page.getByLabel("Size", { exact: true }).first();
  await typed.fill("4.25");
  await typed.press("Enter");
  check("a size is typed", (await page.locator("#size").inputValue()) === "4.25");
  await typed.fill("500");
  await typed.press("Enter");
  const wrong = page.locator(".row:has(#size) .wrong");
  const output = await wrong.textContent();
  check(
    `invalid input is reported: ${output}`,
    Number(/^Size can be 0\.5 to ([\d.]+) mm\. It stays 4\.25 mm\.$/.exec(output)?.[1]) >= 120,
  );
  check(
    "and has changed nothing",
    (await page.locator("#size").inputValue()) === "4.25" && (await typed.inputValue()) === "4.25",
  );
  await typed.fill("120");
  await typed.press("Enter");
  check(
    "a tool may be as large as the piece",
    (await page.locator("#size").inputValue()) === "120" && (await wrong.textContent()) === "",
  );
  // Along the slider, equal distances are equal ratios.
  const slider = page.locator("#size ~ input[type=range], input[type=range]:has(~ #size)").first();
  await slider.focus();
  await page.keyboard.press("Home");
  check("the slider begins with the least", (await typed.inputValue()) === "0.5");
  const box = await slider.boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  const middle = Number(await typed.inputValue());
  check(`its middle is the geometric mean (${middle})`, middle > 5.5 && middle < 11);
  // Keys set the slider, and the number follows.
  await page.locator("#view").focus();
  await page.keyboard.press("]");
  check(
    "the number follows the keys",
    Math.abs(Number(await typed.inputValue()) - 1.15 * middle) < 0.1,
  );

  await page.locator("#shapes label:has(input[value=box])").click();
  await page.locator("#turn-by-typed").fill("45");
  await page.locator("#turn-by-typed").press("Enter");
  await page.locator("#depth-typed").fill("1.5");
  await page.locator("#depth-typed").press("Enter");
  await page.locator("input[name=mode][value='deposit']").check();
  await page.keyboard.press("x");
  check("the turn can be reset", await page.locator("#turn-reset").isVisible());
  const size = await page.locator("#size").inputValue();
  await page.reload();
  await shown(page);
  const kept = await page.evaluate(() =>
    ["size", "depth", "turn-by"].map((id) => document.getElementById(id).value),
  );
  check(`numbers are kept, but not the turn (${kept})`, kept.join() === [size, "1.5", "0"].join());
  check(
    "shape and work are kept",
    (await page.locator("#shape-out").textContent()) === "Box" &&
      (await page.locator("input[name=mode][value='deposit']").isChecked()),
  );
  check("mirrors are off", (await page.locator("#symmetry input:checked").count()) === 0);
  check("the wood is the piece's, still", (await adds()) === "walnut");
  await page.context().close();
  check("the studio ends well", (await studio.end()) === 0);
}

async function whoHoldsTheToolAndWhoIsGone() {
  const file = join(folder, "line.kibori");
  const studio = await Studio.start(file);
  const page = await open({ width: 800, height: 500 });
  await page.clock.install();
  await enter(page, studio.url);
  await shown(page);
  const watcher = await page.context().newPage();
  await watcher.goto(new URL(studio.url).origin);
  await until(watcher, "a solid", (s) => s.shown === "solid" && Number(s.volume) > 0);
  await watcher.locator("#watching").waitFor();
  check(
    "a watcher is notified",
    /carve in another window/.test(await watcher.locator("#watching").textContent()) &&
      !(await page.locator("#watching").isVisible()),
  );
  await show(watcher, "watching");
  await watcher.locator("#take").click();
  await page.locator("#watching").waitFor();
  await watcher.locator("#watching").waitFor({ state: "hidden" }); // it has the tool now
  await watcher.close();

  const port = new URL(studio.url).port;
  await studio.end("SIGKILL");
  const lost = page.locator("#lost");
  await lost
    .filter({ hasText: /Start 'kibori studio' again .* open the address .* Trying again/ })
    .waitFor();
  await show(page, "lost");
  check("it tries by itself at first", !(await page.locator("#again").isVisible()));
  await eventually("and after a minute when it is asked to", async () => {
    await page.clock.fastForward(9000);
    return page.locator("#again").isVisible();
  });
  check("it says so", !/Trying/.test(await lost.textContent()));
  let tries = 0;
  page.on("websocket", () => tries++);
  await page.clock.fastForward(120000);

  // A new studio at the same address does not know this page's key.
  const restarted = await Studio.start(file, "--port", port);
  await page.locator("#again").click();
  await lost
    .filter({
      hasText: "The studio was restarted: open the address that it printed in the terminal.",
    })
    .waitFor();
  check(`meanwhile it was quiet: it tried when asked to (${tries})`, tries === 1);
  await show(page, "anew");
  // After the new studio's address was opened in this browser, it accepts this page, too.
  const other = await page.context().newPage();
  await enter(other, restarted.url);
  await shown(other);
  await page.locator("#again").click();
  await lost.waitFor({ state: "hidden" });
  await until(page, "the piece again", (s) => s.shown === "solid");
  check("it is there again", (await state(page)).hash === (await state(other)).hash);
  await page.context().close();
  check("the studio ends well", (await restarted.end()) === 0);
}

await run([nothingCoversAnything, sheetByTouch, numbersAndWhatIsKept, whoHoldsTheToolAndWhoIsGone]);
