// SPDX-License-Identifier: MIT
// Splines in a real browser. Points are put on the piece and dragged, with a preview. The spline is
// applied, carved over and edited later. The command line gets the same result. See harness.mjs.
// Usage: node test_splines.mjs KIBORI [SCREENSHOTS]
import { readdirSync } from "node:fs";
import { join } from "node:path";
import {
  answered,
  check,
  enter,
  frames,
  kibori,
  open,
  run,
  show,
  shown,
  started,
  state,
  steady,
  Studio,
  until,
  verified,
  visible,
} from "./harness.mjs";

const SIZE = { width: 1280, height: 800 };
async function press(page, { x, y }, to = null) {
  await page.mouse.move(x, y);
  await page.mouse.down();
  if (to) await page.mouse.move(to.x, to.y, { steps: 10 });
  await page.mouse.up();
  await frames(page);
}
const errorText = (page) => page.locator("#spline-says").textContent();
/**
 * Waits until the page is at rest and has drawn. A slow machine draws shadows only after the user
 * leaves the spline.
 */
async function rests(page) {
  await answered(page); // an outdated preview is requested once more
  await steady(page);
  await visible(page);
  return state(page);
}
const volume = async (page) => Number((await rests(page)).volume);

async function drawn() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  await started(page);
  await page.locator('input[name=stock][value="0"]').check();
  await page.locator("#wood").selectOption({ label: "walnut" });
  await page.locator("#detail").selectOption("192");
  await page.locator("#go").click();
  await shown(page);
  await page.locator("#bodies-box summary").click();
  const middle = await page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
  const whole = Number((await state(page)).volume);
  let last = await state(page);

  // A rod across the top.
  await page.locator("#view").focus();
  await page.keyboard.press("Shift+K");
  check("the page says how", /each point/.test(await page.locator("#notice").textContent()));
  const points = [
    { x: middle.x - 150, y: middle.y - 10 },
    { x: middle.x - 60, y: middle.y - 30 },
    { x: middle.x + 30, y: middle.y - 55 },
    { x: middle.x + 110, y: middle.y - 90 },
  ];
  for (const point of points) await press(page, point);
  const rod = await volume(page);
  check(`what it would add is shown (${rod - whole} mm³)`, rod > whole + 1000);
  check("and is no step", (await state(page)).step === last.step);
  await show(page, "splines-points");

  // Drag a point up, off the piece. The rod follows.
  await page.mouse.move(points[1].x, points[1].y);
  await page.mouse.down();
  await page.mouse.move(points[1].x + 10, points[1].y - 30, { steps: 20 });
  await rests(page);
  await show(page, "splines-held");
  await page.mouse.up();
  const arch = await volume(page);
  check(`the rod goes along (${arch - rod} mm³)`, arch > rod + 100);
  await page.locator("#spline-size").fill("6");
  check("thicker", (await volume(page)) > arch + 500);
  await page.locator("#spline-size").fill("4");
  await page.locator("#view").focus();
  await page.keyboard.press("Enter");
  last = await until(page, "the rod", (s) => Number(s.step) > Number(last.step));
  check("applied, it is what was shown", Math.abs((await volume(page)) - arch) < 1e-6 * whole);
  check("the choices are gone", !(await page.locator("#spline-choices").isVisible()));

  // Carve a stroke over it, then edit the spline.
  await press(
    page,
    { x: middle.x - 100, y: middle.y + 40 },
    { x: middle.x + 120, y: middle.y + 10 },
  );
  last = await until(page, "a stroke", (s) => Number(s.step) > Number(last.step));
  const carved = await volume(page);
  check("the stroke took something", carved < arch - 10);
  await page.locator("#spline-edit").click();
  await until(page, "what was before it", (s) => Number(s.step) === 1);
  await rests(page);
  check(
    "taken up again, it is as it was applied",
    Math.abs((await volume(page)) - arch) < 1e-6 * whole,
  );
  await page.locator("#spline-size").fill("3");
  await rests(page);
  await show(page, "splines-changed");
  await page.locator("#spline-apply").click();
  const revised = await until(
    page,
    "the stroke done again",
    (s) => Number(s.step) > Number(last.step) + 1 && !/^0*$/.test(s.hash),
  );
  const thinner = await volume(page);
  check(
    `thinner, and carved (${carved} to ${thinner})`,
    thinner < carved && thinner > whole - 2000,
  );

  // Cancelling changes nothing.
  await page.locator("#view").focus();
  await page.keyboard.press("Shift+K");
  await page.locator("#spline-operation").selectOption("cut");
  for (const point of points) await press(page, { x: point.x, y: point.y + 60 });
  check("a cut is shown", (await volume(page)) < thinner - 100);
  await page.keyboard.press("Escape");
  check("left off, it is gone", Math.abs((await volume(page)) - thinner) < 1e-6 * whole);
  check("and there is no step of it", (await state(page)).step === revised.step);

  // An extruded profile, and the message for an impossible one.
  await page.keyboard.press("Shift+K");
  await page.locator("#spline-kind").selectOption("extrude");
  await page.locator("#spline-size").fill("60");
  for (const [x, y] of [
    [-40, -40],
    [50, -50],
    [60, 20],
    [-30, 40],
  ])
    await press(page, { x: middle.x + x, y: middle.y + y });
  await page.locator("#spline-closed").check();
  check(`it can be (${await errorText(page)})`, (await volume(page)) < thinner - 1000);
  await page.locator("#view").focus();
  await page.keyboard.press("Enter");
  last = await until(page, "the hole", (s) => Number(s.step) > Number(revised.step));
  await rests(page);
  await show(page, "splines-hole");
  await page.keyboard.press("Shift+K");
  await page.locator("#spline-kind").selectOption("sweep");
  await page.locator("#spline-closed").uncheck();
  await page.locator("#spline-size").fill("90");
  for (const point of points) await press(page, point);
  await rests(page);
  check(
    `invalid input is reported (${await errorText(page)})`,
    /thicker/.test(await errorText(page)),
  );
  await page.keyboard.press("Escape");
  await page.locator("#leave").click();
  await started(page);
  check("carved again without differences", verified());
  await studio.end();
}

await run([drawn]);
