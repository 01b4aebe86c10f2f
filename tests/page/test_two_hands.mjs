// SPDX-License-Identifier: MIT
// Two hands in a real browser. Two fingers on the screen, each with its own tool, make one stroke.
// The pointer also works in parallel with a device. The command line replays the result. See
// harness.mjs. Usage: node test_two_hands.mjs KIBORI [SCREENSHOTS]
import { readdirSync } from "node:fs";
import { join } from "node:path";
import {
  after,
  atRest,
  check,
  enter,
  kibori,
  open,
  pace,
  run,
  show,
  shown,
  started,
  state,
  steady,
  Studio,
  until,
  verified,
  inPopover,
} from "./harness.mjs";

const SIZE = { width: 1280, height: 800 };

async function begin(page, url) {
  await enter(page, url);
  await started(page);
  await page.locator('input[name=stock][value="0"]').check();
  await page.locator("#wood").selectOption({ label: "limewood" });
  await page.locator("#detail").selectOption("192");
  await page.locator("#go").click();
  await shown(page);
}
const choose = (page, name, value) =>
  page.evaluate(
    ([name, value]) => document.querySelector(`input[name=${name}][value=${value}]`).click(),
    [name, value],
  );

async function twoFingers() {
  const studio = await Studio.start();
  const page = await open(SIZE, { hasTouch: true });
  await begin(page, studio.url);
  const first = await state(page);
  const glass = await page.context().newCDPSession(page);
  const touch = (type, ...places) =>
    glass.send("Input.dispatchTouchEvent", {
      type,
      touchPoints: places.map(([id, x, y]) => ({ id, x, y })),
    });
  const middle = await page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
  const at = (dx, dy) => [middle.x + dx, middle.y + dy];

  check("no second hand is shown", !(await page.locator("#second-tool").isVisible()));
  await choose(page, "shape", "flat");
  await inPopover(page, "#second-mode", (one) => one.selectOption("cut"));
  check(
    "it takes the tool that is chosen",
    /Flat|End/i.test(await page.locator("#second-name").textContent()),
  );
  await choose(page, "shape", "ball");
  check(
    "and keeps it when another is chosen",
    /Flat|End/i.test(await page.locator("#second-name").textContent()),
  );
  const eye = await page.evaluate(() => window.kibori.eye());

  // The page sends a new depth at once. A later change of settings would divide the next stroke.
  await page.locator("#depth").fill("3");
  // Both at once, back and forth in two grooves. The second finger comes later and leaves earlier.
  await touch("touchStart", [1, ...at(-160, -40)]);
  for (let i = 1; i <= 40; i++) {
    const one = [1, ...at(-160 + 8 * i, -40)],
      two = [2, ...at(160 - 8 * (i - 8), 40)];
    if (i === 8) await touch("touchStart", one, two);
    else if (i === 32)
      await touch("touchMove", one); // the other is lifted
    else if (i > 8 && i < 32) await touch("touchMove", one, two);
    else await touch("touchMove", one);
    await pace(page, 20);
    if (i === 24) {
      await show(page, "two-hands");
      check(
        "the second hand's force is shown",
        parseFloat(await page.locator("#second-newtons").textContent()) > 0,
      );
    }
  }
  await touch("touchEnd");
  let last = await until(page, "the stroke", (s) => s.step !== first.step && s.hash !== first.hash);
  last = await atRest(page);
  check(`one stroke of both (${last.step})`, Number(last.step) === Number(first.step) + 1);
  check(
    "the view stands still",
    JSON.stringify(await page.evaluate(() => window.kibori.eye())) === JSON.stringify(eye),
  );
  await show(page, "two-hands-carved");
  await page.keyboard.press("Control+z");
  await until(page, "both are taken back", (s) => s.hash === first.hash);
  await page.keyboard.press("Control+Shift+z");
  await until(page, "and are there again", (s) => s.hash === last.hash);

  // The second hand adds while the first carves. The first is lifted earlier.
  await inPopover(page, "#second-mode", (one) => one.selectOption("deposit"));
  await touch("touchStart", [1, ...at(-160, -80)]);
  await touch("touchStart", [1, ...at(-150, -80)], [2, ...at(0, 80)]);
  for (let i = 1; i <= 20; i++) {
    await touch("touchMove", [1, ...at(-150 + 8 * i, -80)], [2, ...at(6 * i, 80)]);
    await pace(page, 20);
  }
  await touch("touchMove", [2, ...at(120, 80)]); // the first is lifted
  for (let i = 1; i <= 10; i++) {
    await touch("touchMove", [2, ...at(120 + 4 * i, 80)]);
    await pace(page, 20);
  }
  await touch("touchEnd");
  // This makes one step or two, because the first hand may end before or after the second one.
  last = await after(page, last.step);
  await show(page, "two-hands-added");

  // Without a second hand, two fingers control the view again.
  await inPopover(page, "#second-mode", (one) => one.selectOption("off"));
  const before = await state(page);
  await touch("touchStart", [1, ...at(-100, 0)]);
  await touch("touchStart", [1, ...at(-100, 0)], [2, ...at(100, 0)]);
  for (let i = 1; i <= 10; i++)
    await touch("touchMove", [1, ...at(-100 - 6 * i, 0)], [2, ...at(100 + 6 * i, 0)]);
  await touch("touchEnd");
  await atRest(page);
  check(
    "the view moves",
    JSON.stringify(await page.evaluate(() => window.kibori.eye())) !== JSON.stringify(eye),
  );
  check("and nothing is cut", (await state(page)).hash === before.hash);
  await page.locator("#leave").click();
  await started(page);
  check("carved again without differences", verified());
  await studio.end();
}

async function nextToADevice() {
  const studio = await Studio.start("--device", "virtual");
  const page = await open(SIZE);
  await begin(page, studio.url);
  const first = await state(page);
  await inPopover(page, "#second-mode", (one) => one.selectOption("cut"));
  const middle = await page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
  await page.mouse.move(middle.x - 120, middle.y + 60);
  await page.mouse.down();
  await page.mouse.move(middle.x + 120, middle.y + 60, { steps: 30 });
  await pace(page, 300);
  await show(page, "two-hands-device");
  await page.mouse.up();
  await until(page, "a cut beside the device", (s) => Number(s.volume) < Number(first.volume) - 5);
  await page.locator("#leave").click();
  await started(page);
  check("carved again without differences", verified());
  await studio.end();
}

/** A V-gouge follows the stroke in either hand, in an oblique direction. Both grooves are equal. */
async function bothLead() {
  const taken = [];
  for (const device of [[], ["--device", "virtual"]]) {
    const studio = await Studio.start(...device);
    const page = await open(SIZE);
    await begin(page, studio.url);
    await choose(page, "shape", "vee");
    await inPopover(page, "#guide", (one) => one.selectOption("line"));
    if (device.length > 0) {
      await choose(page, "mode", "touch"); // the device's hand moves and only touches
      await inPopover(page, "#second-mode", (one) => one.selectOption("cut"));
      check("it holds the gouge", /V-gouge/.test(await page.locator("#second-name").textContent()));
    }
    const first = await state(page);
    const middle = await page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
    await page.mouse.move(middle.x - 130, middle.y + 40);
    await page.mouse.down();
    await page.mouse.move(middle.x, middle.y - 25, { steps: 20 });
    await page.mouse.move(middle.x + 130, middle.y - 40, { steps: 20 });
    await pace(page, 300);
    await page.mouse.up();
    await until(page, "a groove", (s) => Number(s.volume) < Number(first.volume) - 5);
    // A device's hand continues and only touches.
    if (device.length > 0) await steady(page, (s) => s.volume, 20);
    else await after(page, first.step);
    await show(page, `two-hands-leads-${taken.length}`);
    taken.push(Number(first.volume) - Number((await state(page)).volume));
    await page.locator("#leave").click();
    await started(page);
    check("carved again without differences", verified());
    await studio.end();
  }
  const [one, other] = taken;
  check(`the same groove (${taken} mm3)`, Math.abs(one - other) < 0.03 * one);
}

await run([twoFingers, nextToADevice, bothLead]);
