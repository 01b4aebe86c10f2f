// SPDX-License-Identifier: MIT
// The room around a piece grows, in a real browser: ears are pulled out of a ball, far beyond the
// room that it had. Usage: node test_growth.mjs KIBORI [SCREENSHOTS]
import {
  after,
  atRest,
  check,
  drag,
  enter,
  eventually,
  lookBy,
  open,
  run,
  show,
  shown,
  started,
  state,
  Studio,
  until,
  verified,
} from "./harness.mjs";

const BALL_MM = 40; // radius of the ball
const EAR_MM = 30;

const onScreen = (page, place) => page.evaluate((p) => window.kibori.onScreen(p), place);
const at = (page, { x, y }) => page.evaluate((p) => window.kibori.at(p.x, p.y), { x, y });

/** Distance [mm] from the ball's middle to the end of an ear, as seen along a line of pixels. */
async function farthest(page, px) {
  for (let mm = BALL_MM + EAR_MM + 12; mm > BALL_MM; mm--) if (await at(page, px(mm, 0))) return mm;
  return 0;
}
/** Width [mm] of an ear at a distance from the ball's middle. */
async function width(page, px, mm) {
  let seen = 0;
  for (const side of [-1, 1])
    for (let off = 0; off < 20 && (await at(page, px(mm, side * off))); off++) seen++;
  return seen;
}

async function ears() {
  const studio = await Studio.start();
  const page = await open({ width: 1280, height: 800 });
  await enter(page, studio.url);
  await started(page);
  await page.locator('input[name=stock][value="2"]').check();
  await page.locator("#length").fill(String(2 * BALL_MM));
  await page.locator("#wood").selectOption({ label: "limewood" });
  await page.locator("#detail").selectOption("192");
  await page.locator("#go").click();
  await shown(page);
  await lookBy(page, "1");
  // Moves the camera away, so that the ears are in the picture.
  await page.mouse.move(900, 400);
  for (let i = 0; i < 4; i++) await page.mouse.wheel(0, 200);
  await atRest(page);
  const centre = await page.evaluate(() => window.kibori.middle());
  const middle = await onScreen(page, centre);
  const aside = await onScreen(page, [centre[0] + 10, centre[1], centre[2]]);
  const perMm = Math.hypot(aside.x - middle.x, aside.y - middle.y) / 10;
  await page.locator("input[name=brush][value=grab]").check({ force: true });
  await page.locator("#size").fill("12");
  await page.locator("#brush-strength").fill("100");
  const hashes = [(await state(page)).hash];
  const steps = [
    { x: -1, y: 0 },
    { x: 1, y: 0 },
    { x: 0, y: -1 },
  ];
  const lines = steps.map((step) => (mm, off) => ({
    x: middle.x + (step.x * mm + step.y * off) * perMm,
    y: middle.y + (step.y * mm + step.x * off) * perMm,
  }));
  for (const px of lines) {
    const before = await state(page);
    await drag(page, [px(BALL_MM - 6, 0), px(BALL_MM + EAR_MM, 0)], { steps: 20 });
    hashes.push((await after(page, before.step)).hash);
  }
  await atRest(page);
  await show(page, "ears");
  for (const px of lines) {
    const tip = await farthest(page, px);
    check(
      `an ear of ${tip - BALL_MM} mm`,
      tip > BALL_MM + EAR_MM - 4 && tip < BALL_MM + EAR_MM + 10,
    );
    // It does not end in a flat disc: it is narrower at its end.
    const end = await width(page, px, tip - 2),
      root = await width(page, px, BALL_MM + 4);
    check(`it is ${end} mm wide at its end and ${root} mm at its root`, end < 0.8 * root);
  }
  check(
    "no notice about the size",
    !/largest size/.test(await page.locator("#notice").textContent()),
  );
  // Undo and redo take the growth back and repeat it.
  await page.locator("#view").focus();
  for (let i = steps.length - 1; i >= 0; i--) {
    await page.keyboard.press("Control+z");
    await until(page, "undone", (s) => s.hash === hashes[i]);
  }
  await atRest(page);
  check("no ear is left", !(await at(page, { x: middle.x - (BALL_MM + 5) * perMm, y: middle.y })));
  for (let i = 1; i < hashes.length; i++) {
    await page.keyboard.press("Control+y");
    await until(page, "redone", (s) => s.hash === hashes[i]);
  }
  await atRest(page);
  check("the ear is back", await at(page, { x: middle.x - (BALL_MM + 20) * perMm, y: middle.y }));
  // Another window shows the whole piece from the beginning.
  const other = await open({ width: 1280, height: 800 });
  await enter(other, await studio.another());
  await shown(other);
  await eventually("all of it", () => other.evaluate(() => window.kibori.whole()));
  await show(other, "ears-again");
  const bytes = (window_) => window_.evaluate(() => window.kibori.surface().length);
  check("it is the same surface", (await bytes(page)) === (await bytes(other)));
  await page.keyboard.press("Control+o");
  await started(page);
  check("the command line carves the same", verified());
  await studio.end();
}

await run([ears]);
