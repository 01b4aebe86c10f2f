// SPDX-License-Identifier: MIT
// A milling program in the page: it is opened like any file, played, scrubbed, stopped at a
// collision, and kept as a document. See harness.mjs.
import { execFileSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import {
  check,
  drawn,
  enter,
  eventually,
  fetched,
  folder,
  kibori,
  newest,
  open,
  pictures,
  run,
  show,
  shown,
  started,
  state,
  Studio,
  until,
  verified,
  visible,
} from "./harness.mjs";

// ---- Files

function file(name, content) {
  const path = join(folder, name);
  writeFileSync(path, content);
  return path;
}

/** A pocket in layers, a border, and a rapid move through the wall. */
const PROGRAM = ["(a bowl)", "T1 M6", "S9000 M3", "G0 X30 Y20 Z5", "G1 F800"];
for (let z = -1; z >= -9; z -= 1)
  for (let r = 3; r <= 14 + z / 2; r += 2.5)
    PROGRAM.push(`G1 X${30 + r} Y20 Z${z}`, `G3 X${30 + r} Y20 I${-r} J0`);
PROGRAM.push("G0 Z5", "(the next move is too low)", "G0 X4 Y4", "G0 Z-3", "G0 X56 Y4");
const HIT = PROGRAM.length - 1; // down into the block
PROGRAM.push("G0 Z5", "T2 M6", "S12000 M3", "G0 X4 Y36", "G1 Z-1 F300", "G1 X56", "G0 Z20", "M2");
const TOOLS = [6, 3]
  .map(
    (d, i) =>
      `[[tool]]\nnumber = ${i + 1}\ncutter = { shape = "${i ? "flat" : "ballnose"}", radius = ${d / 2}, length = 25 }\n` +
      `shank = [${d}, 40]\nteeth = 2\n`,
  )
  .join("");
const STOCK = [0, 0, -12, 60, 40, 0];
const JOB = `stock = [${STOCK}]\npitch = 0.4\nmaterial = "beech"\ntools = "tools.toml"\n[[setup]]\nprograms = ["bowl.nc"]\n`;
const paths = {
  program: file("bowl.nc", `${PROGRAM.join("\n")}\n`),
  tools: file("tools.toml", TOOLS),
  job: file("job.toml", JOB),
  wrong: file("wrong.nc", "G0 X1\nG68 X2\n"),
};
/** The hash of the result of 'kibori mill'. */
const milled = (...words) =>
  JSON.parse(execFileSync(kibori, ["mill", ...words, "--json"], { encoding: "utf8" })).state_hash;

// ---- The page

const played = async (page) => (await state(page)).job?.split(" ") ?? [];
const line = async (page) => Number((await played(page))[2]);
const reaches = (page, what, holds) =>
  until(page, what, (s) => s.job !== undefined && holds(s.job.split(" "), s));
const computed = (page) => reaches(page, "all is computed", ([, how]) => how === "done");
const hash = (page, wanted) =>
  until(page, `the model ${wanted}`, (s) => s.hash === wanted.replace(/^0x/, ""));
const selected = (page, number) =>
  page.locator(`#program-text [data-line="${number}"][aria-selected=true]`);
async function speed(page, value) {
  await page.locator("#job-speed").selectOption(value);
}
async function tab(page, name) {
  const button = page.locator(`.tab[data-panel=${name}]`);
  if (!(await button.isVisible())) return; // a wide window shows all panels
  if ((await button.getAttribute("aria-expanded")) === "false") await button.click();
}
/** Everything of these parts is within the window. */
const fits = (page, ...ids) =>
  page.evaluate(
    (all) =>
      all.every((id) => {
        const r = document.getElementById(id).getBoundingClientRect();
        return r.width > 0 && r.left >= 0 && r.right <= innerWidth && r.bottom <= innerHeight;
      }),
    ids,
  );
async function seek(page, share) {
  await page.locator("#job-time").evaluate((time, at) => {
    time.value = String(at * Number(time.max));
    for (const kind of ["input", "change"]) time.dispatchEvent(new Event(kind));
  }, share);
}

async function begun(size, more) {
  const studio = await Studio.start(),
    page = await open(size, more);
  await enter(page, studio.url);
  await started(page);
  return { studio, page };
}
async function ended({ studio, page }) {
  await page.context().close();
  await studio.end();
}

// A job of several files: all of playback, on a large and on a small screen.
async function job() {
  const whole = milled(paths.job);
  for (const size of [
    { width: 1280, height: 800 },
    { width: 390, height: 844 },
  ]) {
    const name = size.width < 600 ? "phone" : "desk";
    const at = await begun(size, { draws: pictures !== undefined }),
      { page } = at;
    await page.locator("#file").setInputFiles([paths.job, paths.program, paths.tools]);
    await computed(page);
    await visible(page);
    const stock = (await until(page, "a hash", (s) => !/^0*$/.test(s.hash ?? "0"))).hash;
    check("it waits at the begin", (await line(page)) === 0);
    check("the time line fits", await fits(page, "transport", "job-play", "job-keep"));
    // It stops at the collision.
    await speed(page, "0");
    await page.locator("#job-play").click();
    await reaches(
      page,
      "it stops at the collision",
      ([how, , at]) => how === "paused" && at == HIT,
    );
    await tab(page, "milling");
    await page
      .locator("#job-stopped")
      .filter({ hasText: `line ${HIT}` })
      .waitFor();
    check("two problems", (await page.locator("#job-problems li").count()) === 2);
    check(
      "the first one is marked",
      (await page.locator("#job-problems li").first().getAttribute("class")) === "current",
    );
    await page.locator("#job-curve .now").waitFor();
    await show(page, `playback-${name}-forces`);
    await tab(page, "program");
    await selected(page, HIT)
      .filter({ hasText: PROGRAM[HIT - 1] })
      .waitFor();
    check("it is marked", (await selected(page, HIT).getAttribute("class")) === "bad");
    if (pictures) await drawn(page);
    await show(page, `playback-${name}`);
    // Without stops it reaches the end, which equals the result of the command.
    await page.locator("#job-stops").uncheck();
    await page.locator("#job-play").click();
    await hash(page, whole);
    // Scrubbing there and back.
    await seek(page, 0.3);
    await until(page, "another state", (s) => s.hash !== whole && s.hash !== stock);
    await seek(page, 0);
    await hash(page, stock);
    await seek(page, 1);
    await hash(page, whole);
    // By lines: a click, and steps. Comments do not move.
    // The text may still follow the position that was chosen before.
    await eventually("line 8 is clicked", async () => {
      await page.locator("#program-text").evaluate((text) => (text.scrollTop = 0));
      const row = page.locator("#program-text [data-line='8']");
      return row.click({ timeout: 2000 }).then(
        () => true,
        () => false,
      );
    });
    await reaches(page, "line 8", ([, , at]) => at === "8");
    await page.locator("#job-next").click();
    await reaches(page, "line 9", ([, , at]) => at === "9");
    await page.locator("#job-back").click();
    await reaches(page, "line 8 again", ([, , at]) => at === "8");
    await page.locator("#program-text").press("ArrowDown");
    await reaches(page, "line 9 by a key", ([, , at]) => at === "9");
    await show(page, `playback-${name}-part`);
    // A problem is a place to go to.
    await tab(page, "milling");
    await page.locator("#job-problems button").nth(1).click();
    await reaches(page, "the second problem", ([, , at]) => at == HIT + 1);
    if (name === "desk") await keep(page, whole);
    await page.locator("#leave").click();
    await started(page);
    await ended(at);
  }
}

async function keep(page, whole) {
  await page.locator("#job-keep").click();
  await page.locator("#keep-name").fill("my bowl");
  await show(page, "playback-keep");
  await page.locator("#keeping button[value=yes]").click();
  const now = await shown(page);
  check("the stock and a step for each tool", now.step === "3");
  check("a replay agrees", verified());
  check("its end is that of the job", now.hash === whole);
  check("it is carved like any document", !(await page.locator("#transport").isVisible()));
  check("its panels are back", await page.locator("#tools").isVisible());
  const history = execFileSync(kibori, ["history", newest()], { encoding: "utf8" });
  check(`it knows the lines (${history})`, history.includes("bowl.nc"));
}

// A program alone: the page asks for the stock and the tool.
async function alone() {
  const at = await begun({ width: 1280, height: 800 }, { colorScheme: "dark" }),
    { page } = at;
  await page.locator("#file").setInputFiles(paths.wrong);
  await eventually("the refusal", async () =>
    /wrong\.nc:2: .*G68/.test(await page.locator("#notice").textContent()),
  );
  await page.locator("#file").setInputFiles(paths.program);
  await page.locator("#milling-job[open]").waitFor();
  await show(page, "playback-dialog");
  check("the top is at 0", (await page.locator("#job-z1").inputValue()) === "0");
  await page.locator("#job-x1").fill("-100");
  await page.locator("#milling-job button[value=yes]").click();
  await page.locator("#milling-job-trouble").filter({ hasText: "along x" }).waitFor();
  const [x0, y0, z0, x1, y1, z1] = STOCK;
  for (const [id, value] of Object.entries({ x0, y0, z0, x1, y1, z1, pitch: 0.5, diameter: 4 }))
    await page.locator(`#job-${id}`).fill(String(value));
  await page.locator("#milling-job button[value=yes]").click();
  await computed(page);
  // The same tools for the command.
  const tools = file(
    "same.toml",
    [1, 2]
      .map(
        (n) =>
          `[[tool]]\nnumber = ${n}\ncutter = { shape = "flat", radius = 2, length = 40 }\nteeth = 2\n`,
      )
      .join(""),
  );
  const whole = milled(paths.program, "--stock", STOCK.join(), "--tools", tools, "--pitch", "0.5");
  await seek(page, 1);
  await hash(page, whole);
  await visible(page);
  await show(page, "playback-dark");
  // Real time: the tool moves within a line.
  await seek(page, 0);
  await speed(page, "1");
  await page.locator("#job-play").click();
  await reaches(page, "it plays", ([how, , at]) => how === "playing" && Number(at) > 0);
  await page.locator("#job-play").click();
  await reaches(page, "it pauses", ([how]) => how === "paused");
  const stl = await fetched(page, "/export?format=stl");
  check("the shown state can be exported", stl.length > 84);
  await page.locator("#leave").click();
  await started(page);
  await ended(at);
}

await run([job, alone]);
