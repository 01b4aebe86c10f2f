// SPDX-License-Identifier: MIT
// Bodies in a real browser: cut along drawn lines, chosen, moved, turned, joined and so on. Also
// the pieces that strokes sever. The command line then replays everything from the document. Usage:
// node test_bodies.mjs KIBORI [SCREENSHOTS]
import { execFileSync } from "node:child_process";
import {
  after,
  atRest,
  check,
  drag,
  enter,
  kibori,
  lookBy,
  newest,
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

const SIZE = { width: 1280, height: 800 };

async function begun(page) {
  await started(page);
  await page.locator('input[name=stock][value="0"]').check();
  await page.locator("#wood").selectOption({ label: "limewood" });
  await page.locator("#detail").selectOption("192");
  await page.locator("#go").click();
  await shown(page);
  await page.locator("#view").focus();
  return page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
}
/** The state and the list of bodies after a later step, with its surface. */
const listed = async (page, step) => ({
  ...(await after(page, step)),
  list: await bodies(page),
});
const bodies = (page) =>
  page.evaluate(() =>
    [...document.querySelectorAll("#body-list li")].map((row) => ({
      id: Number(row.dataset.body),
      name: row.querySelector(".name").textContent,
      current: row.classList.contains("current"),
      visible: row.querySelector(".visible").ariaPressed === "false",
      locked: row.querySelector(".locked").ariaPressed === "true",
    })),
  );
const active = (page, id) =>
  page.locator(`#bodies-box[data-active="${id}"]`).waitFor({ state: "attached" });
const reported = () =>
  JSON.parse(execFileSync(kibori, ["bodies", newest(), "--json"], { encoding: "utf8" }));
const click = (page, id) => page.locator(`#body-${id}`).click();
const row = (page, id) => page.locator(`#body-list li[data-body="${id}"]`);
async function close(page) {
  await page.locator("#leave").click();
  await started(page);
}

async function everyVerb() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page);
  const whole = Number((await state(page)).volume);
  await page.locator("#bodies-box summary").click();
  let last = await state(page);
  check("there is one body", (await bodies(page)).length === 1);

  // Cut with the key and a straight line. The cut part becomes a separate body.
  await page.locator("#view").focus();
  await page.keyboard.press("k");
  check("the page says how", /Draw a line/.test(await page.locator("#notice").textContent()));
  await drag(page, [
    { x: middle.x + 70, y: middle.y - 190 },
    { x: middle.x + 40, y: middle.y + 190 },
  ]);
  last = await listed(page, last.step);
  check(`cut: there are two bodies (${last.list.length})`, last.list.length === 2);
  check("cut: the larger one is worked on still", last.list[0].current);
  check("cut: nothing is lost", Math.abs(Number(last.volume) / whole - 1) < 1e-6);
  await show(page, "bodies-cut");

  // Move it away, so that it is visible.
  await row(page, 2).locator(".name").click();
  await active(page, 2);
  await click(page, "move");
  await drag(page, [
    { x: middle.x + 150, y: middle.y },
    { x: middle.x + 215, y: middle.y + 30 },
  ]);
  last = await listed(page, last.step);
  await click(page, "turn");
  await drag(page, [
    { x: middle.x + 190, y: middle.y },
    { x: middle.x + 230, y: middle.y - 20 },
  ]);
  last = await listed(page, last.step);
  await show(page, "bodies-moved");

  // A stroke on the moved and turned body cuts at the pointer.
  const at = await page.evaluate((m) => {
    for (let x = m.x + 330; x > m.x + 80; x -= 4)
      for (const y of [m.y, m.y + 30, m.y - 30])
        if (window.kibori.onPiece(x, y) && window.kibori.onPiece(x - 40, y))
          return { x: x - 10, y };
    return null;
  }, middle);
  check("the body that was moved is under the pointer", at !== null);
  const before = await page.evaluate((p) => window.kibori.at(p.x - 15, p.y), at);
  await drag(
    page,
    [
      { x: at.x, y: at.y },
      { x: at.x - 30, y: at.y },
    ],
    { hold: 500 },
  );
  last = await listed(page, last.step);
  const cut = await page.evaluate((p) => window.kibori.at(p.x - 15, p.y), at);
  check(
    "the stroke cut where it was drawn",
    cut === null || Math.hypot(...cut.map((c, i) => c - before[i])) > 0.3,
  );
  await show(page, "bodies-carved");

  for (const verb of ["duplicate", "mirror", "bake"]) {
    await click(page, verb);
    last = await listed(page, last.step);
  }
  check(`duplicate: three bodies (${last.list.length})`, last.list.length === 3);

  // Hide, lock and name a body.
  await row(page, 3).locator(".visible").click();
  last = await listed(page, last.step);
  check("hide: it is not shown", !last.list[2].visible);
  await row(page, 2).locator(".locked").click();
  last = await listed(page, last.step);
  check("lock", last.list[1].locked);
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  await page.locator("#notice", { hasText: "is locked" }).waitFor();
  await page.mouse.up();
  check("a stroke on what is locked is refused", (await atRest(page)).step === last.step);
  await row(page, 2).locator(".locked").click();
  last = await listed(page, last.step);
  await row(page, 2).locator(".name").click();
  await page.keyboard.type("Lid <b>");
  await page.keyboard.press("Enter");
  last = await listed(page, last.step);
  check("rename", last.list[1].name === "Lid <b>");

  // Combine it with other bodies.
  await row(page, 1).locator(".name").click();
  await active(page, 1);
  await row(page, 3).locator(".visible").click();
  last = await listed(page, last.step);
  for (const verb of ["subtract", "join"]) {
    const other = row(page, verb === "join" ? 2 : 3).locator("input");
    await other.check();
    await click(page, verb);
    last = await listed(page, last.step);
    if (verb === "subtract") await other.uncheck();
  }
  check(`join: two bodies (${last.list.length})`, last.list.length === 2);
  await click(page, "separate");
  await atRest(page); // separating a body in one piece may make no step
  await row(page, 3).locator(".name").click();
  await active(page, 3);
  last = await state(page);
  await click(page, "remove");
  last = await listed(page, last.step);
  check("delete", !last.list.some((body) => body.id === 3));

  // Undo to the beginning, then redo everything.
  const head = await state(page);
  for (let at = Number(head.step); at > 1; at = Number((await state(page)).step)) {
    await page.locator("#undo").click();
    await until(page, "a step back", (s) => Number(s.step) < at);
  }
  await atRest(page);
  check("undone, there is one body", (await bodies(page)).length === 1);
  check("of the volume it had", Math.abs(Number((await state(page)).volume) / whole - 1) < 1e-9);
  for (let at = 1; at < Number(head.step); at = Number((await state(page)).step)) {
    await page.locator("#redo").click();
    await until(page, "a step forth", (s) => Number(s.step) > at);
  }
  await until(page, "the end again", (s) => s.step === head.step && s.hash === head.hash);
  await close(page);
  check("the command line gives the same result", verified());
  const list = reported();
  check(
    "every body is closed",
    list.every((body) => body.closed),
  );
  await studio.end();
}

/** Severed pieces: a stroke cuts through a slab that was sawn off. */
async function crumbs() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  const middle = await begun(page);
  await page.locator("#bodies-box summary").click();
  let last = await state(page);
  // A slab of some mm at the front, seen from above.
  await lookBy(page, "7");
  const edge = await page.evaluate((m) => {
    let y = m.y;
    while (window.kibori.onPiece(m.x, y)) y++;
    return y;
  }, middle);
  await page.keyboard.press("k");
  await drag(page, [
    { x: middle.x - 260, y: edge - 24 },
    { x: middle.x + 260, y: edge - 24 },
  ]);
  await show(page, "bodies-sawn");
  last = await listed(page, last.step);
  check("there is a slab", last.list.length === 2);
  await row(page, 2).locator(".name").click();
  await active(page, 2);
  await page.locator("#size").fill("6");
  await page.locator("#depth").fill("8");
  const through = async (x) => {
    for (let pass = 0; pass < 10; pass++) {
      await drag(
        page,
        [
          { x, y: edge - 12 },
          { x, y: edge + 30 },
          { x, y: edge - 12 },
        ],
        { hold: 500 },
      );
      // A pass that removes nothing makes no step.
      const then = { ...(await atRest(page)), list: await bodies(page) };
      if (
        then.list.length > last.list.length ||
        /came loose/.test(await page.locator("#notice").textContent())
      )
        return then;
    }
    throw new Error("the slab was not cut through");
  };
  const slab = last.list.length;
  last = await through(middle.x + 40);
  check("half of a slab becomes a body", last.list.length === slab + 1);
  await show(page, "bodies-slab");
  // One end of it falls away.
  await page.locator("#crumbs").selectOption("fall");
  const right = await page.evaluate(
    (p) => {
      let x = p.x;
      while (window.kibori.onPiece(x, p.y)) x--;
      return x;
    },
    { x: middle.x, y: edge - 12 },
  );
  const count = last.list.length;
  last = await through(right + 60);
  check(
    "an end falls away where it is to",
    last.list.length === count && /came loose/.test(await page.locator("#notice").textContent()),
  );
  await show(page, "bodies-fallen");
  const { hash } = last;
  await close(page);
  check("the command line gives the same result", verified());
  check(
    "every body is closed",
    reported().every((body) => body.closed),
  );
  check("a hash", hash.length > 8);
  await studio.end();
}

await run([everyVerb, crumbs]);
