// SPDX-License-Identifier: MIT
// Protected regions in a real browser. A mesh is added as a template, and a stroke through it
// leaves it whole. Colours and numbers show the remaining material, and the command line agrees.
// See harness.mjs. Usage: node test_no_go.mjs KIBORI [SCREENSHOTS]
import { execFileSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import {
  atRest,
  check,
  drag,
  enter,
  folder,
  kibori,
  newest,
  open,
  pace,
  run,
  show,
  shown,
  started,
  state,
  Studio,
  until,
} from "./harness.mjs";

const SIZE = { width: 1280, height: 800 };

/** An ellipsoid with these half axes [mm], as OBJ. */
function ellipsoid(radii) {
  const around = 48,
    up = 24,
    lines = [];
  for (let j = 0; j <= up; j++)
    for (let i = 0; i < around; i++) {
      const a = (2 * Math.PI * i) / around,
        b = (Math.PI * j) / up;
      const v = [Math.sin(b) * Math.cos(a), Math.sin(b) * Math.sin(a), -Math.cos(b)];
      lines.push(`v ${v.map((x, k) => (x * radii[k]).toFixed(5)).join(" ")}`);
    }
  const at = (i, j) => j * around + (i % around) + 1;
  for (let j = 0; j < up; j++)
    for (let i = 0; i < around; i++) {
      if (j > 0) lines.push(`f ${at(i, j)} ${at(i + 1, j)} ${at(i + 1, j + 1)}`);
      if (j + 1 < up) lines.push(`f ${at(i, j)} ${at(i + 1, j + 1)} ${at(i, j + 1)}`);
    }
  // The poles are rings at one position. A mesh needs each position once.
  return lines.join("\n").replaceAll(
    /^f (.*)$/gm,
    (_, f) =>
      `f ${f
        .split(" ")
        .map((n) => pole(Number(n), around, up))
        .join(" ")}`,
  );
}
const pole = (n, around, up) => (n <= around ? 1 : n > up * around ? up * around + 1 : n);

const output = (page) => page.locator("#remains-said").textContent();
const stroke = (page, from, to) => drag(page, [from, to], { steps: 24, hold: 400 });

async function aTemplate() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  await started(page);
  await page.locator('input[name=stock][value="0"]').check();
  await page.locator("#wood").selectOption({ label: "limewood" });
  await page.locator("#detail").selectOption("192");
  await page.locator("#go").click();
  await shown(page);
  await page.locator("#bodies-box summary").click();
  check(
    "without anything no-go there is nothing that remains",
    await page.locator("#body-remains").isDisabled(),
  );

  const file = join(folder, "egg.obj");
  writeFileSync(file, ellipsoid([30, 20, 13]));
  await page.locator("#body-file").setInputFiles(file);
  await page.locator("#importing[open]").waitFor();
  check("a body has no wood of its own", !(await page.locator("#import-wood").isVisible()));
  await page.locator("#import-up").selectOption("z");
  check("it is a template", await page.locator("#import-no-go").isChecked());
  await show(page, "no-go-import");
  let last = await state(page);
  await page.locator("#importing button[value=yes]").click();
  last = await until(page, "the template", (s) => Number(s.step) > Number(last.step));
  await atRest(page);
  const rows = () =>
    page.evaluate(() =>
      [...document.querySelectorAll("#body-list li")].map((row) => ({
        name: row.querySelector(".name").textContent,
        current: row.classList.contains("current"),
        noGo: row.querySelector(".no_go").ariaPressed === "true",
      })),
    );
  const list = await rows();
  check(`there are two bodies (${list.length})`, list.length === 2);
  check("the stock is worked on, the template is no-go", list[0].current && list[1].noGo);
  check("it has the file's name", list[1].name === "egg");
  await show(page, "no-go-veil");

  // A hidden template still protects.
  await page.locator('#body-list li[data-body="2"] .visible').click();
  last = await until(page, "hidden", (s) => Number(s.step) > Number(last.step));
  await page.locator("#body-remains").click();
  await page.locator("#remains-said", { hasText: "At most" }).waitFor();
  await atRest(page);
  const before = await output(page);
  check(`the remaining volume is shown (${before})`, /At most [\d.]+ mm remain/.test(before));
  await show(page, "no-go-remains");

  // Strokes across the top, back and forth.
  const middle = await page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
  for (let i = -2; i <= 2; i++) {
    await stroke(
      page,
      { x: middle.x - 220, y: middle.y + 26 * i },
      { x: middle.x + 220, y: middle.y + 26 * i },
    );
    await atRest(page);
  }
  const after = await output(page);
  check(`less remains (${after})`, after !== before);
  await show(page, "no-go-carved");

  // No tool cuts the template itself. No brush reshapes a body while there is a template.
  await page.locator("#view").focus();
  await page.keyboard.down("Shift");
  await page.mouse.move(middle.x, middle.y);
  await page.mouse.down();
  await pace(page, 300);
  await page.mouse.up();
  await page.keyboard.up("Shift");
  await atRest(page);
  check(
    "what reshapes is refused beside it",
    /protected/.test(await page.locator("#notice").textContent()),
  );
  await page.locator("#body-remains").click();
  check("the colours are gone again", !(await page.locator("#remains").isVisible()));

  // Switch the flag off and on again.
  last = await state(page);
  await page.locator('#body-list li[data-body="2"] .no_go').click();
  last = await until(page, "no flag", (s) => Number(s.step) > Number(last.step));
  await atRest(page);
  check("the flag is off", !(await rows())[1].noGo);
  check("nothing remains then", await page.locator("#body-remains").isDisabled());
  await page.locator('#body-list li[data-body="2"] .no_go').click();
  last = await until(page, "the flag", (s) => Number(s.step) > Number(last.step));
  await page.locator("#leave").click();
  await started(page);

  check(
    "carved again without differences",
    /steps, .*no differences/.test(
      execFileSync(kibori, ["verify", newest()], { encoding: "utf8" }),
    ),
  );
  const reported = JSON.parse(
    execFileSync(kibori, ["bodies", newest(), "--json"], { encoding: "utf8" }),
  );
  const egg = (4 / 3) * Math.PI * 30 * 20 * 13;
  check("the template is whole", Math.abs(reported[1].volume_mm3 / egg - 1) < 0.01);
  check("no-go is reported", reported[1].no_go && !reported[0].no_go);
  const largest = Number(/At most ([\d.]+)/.exec(after)[1]);
  check(
    `the command line measures the same (${reported[0].remains_max_mm})`,
    Math.abs(reported[0].remains_max_mm / largest - 1) < 0.06,
  );
  check(
    "all of the template is within what was carved",
    Math.abs(reported[0].volume_mm3 - reported[0].remains_mm3 - reported[1].volume_mm3) <
      1e-3 * egg,
  );
  await studio.end();
}

async function aMask() {
  const studio = await Studio.start();
  const page = await open(SIZE);
  await enter(page, studio.url);
  await started(page);
  await page.locator('input[name=stock][value="0"]').check();
  await page.locator("#detail").selectOption("192");
  await page.locator("#go").click();
  await shown(page);
  const first = await state(page);
  const middle = await page.evaluate(() => window.kibori.onScreen(window.kibori.middle()));
  const at = (x, y) => ({ x: middle.x + x, y: middle.y + y });
  await page.locator("#bodies-box summary").click();
  await page.locator("#body-mask").click();
  await stroke(page, at(-80, -60), at(60, -60));
  let last = await until(page, "a mask", (s) => Number(s.step) > Number(first.step));
  await atRest(page);
  const rows = await page.locator("#body-list li").count();
  check(`the mask is in the list (${rows})`, rows === 2);
  // Erase part of it.
  await page.keyboard.down("Alt");
  await stroke(page, at(60, -60), at(20, -60));
  await page.keyboard.up("Alt");
  last = await until(page, "less of it", (s) => Number(s.step) > Number(last.step));
  await page.keyboard.press("Escape");
  await page.locator("#bodies-box summary").click();
  const volume = () =>
    JSON.parse(execFileSync(kibori, ["bodies", newest(), "--json"], { encoding: "utf8" }))[1]
      .volume_mm3;
  for (let i = -1; i <= 1; i++) await stroke(page, at(-140, -60 + 14 * i), at(120, -60 + 14 * i));
  await atRest(page);
  await show(page, "no-go-mask");
  check("it was carved beside it", Number((await state(page)).volume) < Number(last.volume) - 50);
  await page.locator("#leave").click();
  await started(page);
  check(
    "carved again without differences",
    /steps, .*no differences/.test(
      execFileSync(kibori, ["verify", newest()], { encoding: "utf8" }),
    ),
  );
  check("the mask holds wood", volume() > 10);
  await studio.end();
}

await run([aTemplate, aMask]);
