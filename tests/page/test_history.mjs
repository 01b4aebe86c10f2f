// SPDX-License-Identifier: MIT
// The history strip and the force plots: groups, keys, branches, thousands of steps, thumbnails
// from one camera. A spike does not flatten a plot. Usage: node test_history.mjs KIBORI
// [SCREENSHOTS' FOLDER]
import { execFileSync, spawn } from "node:child_process";
import { existsSync, renameSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { pathToFileURL } from "node:url";
import {
  atRest,
  check,
  enter,
  eventually,
  fetched,
  folder,
  frames,
  kibori,
  lookBy,
  open,
  pressUntil,
  reports,
  run,
  show,
  shown,
  state,
  Studio,
  until,
  inPopover,
} from "./harness.mjs";

/** Bundles a module of the page that needs no browser. vite includes esbuild. */
async function moduleOf(path) {
  const { build } = await import("../../web/node_modules/esbuild/lib/main.js");
  const out = join(folder, `${basename(path)}.mjs`);
  await build({
    entryPoints: [new URL(`../../web/src/${path}.ts`, import.meta.url).pathname],
    bundle: true,
    format: "esm",
    outfile: out,
    logLevel: "error",
  });
  return import(pathToFileURL(out));
}

async function scalesOfPlots() {
  const { robustRange, spikes } = await moduleOf("forces/robust");
  const even = Array.from({ length: 5000 }, (_, i) => (i < 1000 ? 0 : 10 + Math.sin(i)));
  const spiky = even.map((v, i) =>
    i === 2000 || i === 2003 ? 1000 - i / 1000 : i === 4000 ? -300 : v,
  );
  const calm = robustRange([even], 1),
    range = robustRange([spiky], 1);
  check(
    `a spike of 1000 N leaves 10 N as high as they were (${calm.high}, ${range.high})`,
    calm.high < 13 && range.high < 13 && range.high > 11,
  );
  check(
    "what has no spikes is shown whole",
    calm.low === 0 &&
      Math.max(...even) <= calm.high &&
      spikes(
        even.map((_, i) => i),
        even,
        calm,
        50,
      ).length === 0,
  );
  const marked = spikes(
    spiky.map((_, i) => i),
    spiky,
    { low: 0, high: range.high },
    50,
  );
  check(
    "spikes beside each other are marked once, with the largest",
    marked.length === 2 &&
      marked[0].x === 2000 &&
      marked[0].value === 998 &&
      marked[1].value === -300,
  );
  // A touch that is short compared with the shown time is not a spike.
  const touch = Array.from({ length: 5000 }, (_, i) => (i > 4000 && i < 4020 ? 5 : 0));
  check(
    "a short touch fills the scale",
    robustRange([touch], 1).high < 6 && robustRange([touch], 1).high > 5,
  );
  const ramp = Array.from({ length: 5000 }, (_, i) => i / 500);
  check("a ramp is shown whole", robustRange([ramp], 1).high >= ramp.at(-1));
  check(
    "nothing has a scale, too",
    robustRange([[]], 0).high === 1 &&
      robustRange([[0, null]], 0).high === 1 &&
      robustRange([[]], 10).high === 10,
  );

  const { figure } = await moduleOf("forces/figure");
  const x = spiky.map((_, i) => i / 1000);
  const svg = figure(
    [
      { name: "a <run>", colour: "#d55e00", dashed: false, x, y: spiky.map(Math.abs) },
      { name: "another", colour: "#0072b2", dashed: true, x, y: even },
    ],
    "Force |F| [N]",
    ["A sentence."],
  );
  for (const words of [
    ">Force |F| [N]<",
    ">Time [s]<",
    ">998 N<",
    ">300 N<",
    ">A sentence.<",
    ">a &#60;run&#62;<",
  ])
    check(`the figure says ${words}`, svg.includes(words));
  check("its spikes are marked", svg.split('class="spike"').length === 3);
  if (process.argv[3]) writeFileSync(join(process.argv[3], "figure.svg"), svg);
}

/** Rows of the message Steps. */
function rows(steps) {
  const text = (words) => {
    const bytes = Buffer.from(words),
      count = Buffer.alloc(4);
    count.writeUInt32LE(bytes.length);
    return Buffer.concat([count, bytes]);
  };
  const all = steps.map(([id, parent, made, tool, mode = "cut", pictured = 0, label = ""]) => {
    const row = Buffer.alloc(20);
    row.writeUInt32LE(id, 0);
    row.writeUInt32LE(parent, 4);
    row.writeFloatLE(-2.5, 8);
    row.writeDoubleLE(made, 12);
    return Buffer.concat([
      row,
      text(JSON.stringify(tool)),
      Buffer.from([["cut", "deposit", "touch", "off"].indexOf(mode), pictured]),
      text(label),
    ]);
  });
  return Uint8Array.from(Buffer.concat(all));
}

async function theTreeOfSteps() {
  const { StepTree } = await moduleOf("history/steps");
  const tree = new StepTree();
  const MOVED = "off",
    STOCK = null,
    ball = (radius) => ({ shape: "ball", radius }),
    mill = { shape: "flat", radius: 3, length: 25 };
  tree.add(
    rows([
      [1, 0, 1000, STOCK],
      [2, 1, 1010, ball(4)],
      [3, 2, 1020, ball(4), MOVED],
      [4, 3, 1030, ball(4), "cut", 1],
      [5, 4, 1040, ball(5)],
    ]),
  );
  tree.add(
    rows([
      [6, 5, 1050, ball(5), "deposit", 0, "fills ä"],
      [7, 6, 1400, ball(5), "deposit"],
    ]),
  );
  tree.add(
    rows([
      [8, 2, 1500, mill],
      [9, 8, 1510, mill],
      [10, 8, 1520, mill],
      [11, 7, 1701, ball(5), "deposit"],
    ]),
  );
  tree.setHead(11);
  const path = tree.path();
  check("the way to the head", path.map((s) => s.id).join() === "1,2,3,4,5,6,7,11");
  check(
    "a label, a size",
    tree.get(6).label === "fills ä" &&
      tree.get(5).tool.radius === 5 &&
      tree.get(5).removed === -2.5,
  );
  const groups = (ends = () => false) =>
    tree.groups(path, ends).map((g) => g.steps.map((s) => s.id).join());
  check(
    `groups by tool, size, mode and five minutes: ${groups().join(" ")}`,
    groups().join(" ") === "1 2,3,4 5 6 7 11",
  );
  check("a name ends a group", groups((s) => s.id === 2).join(" ") === "1 2 3,4 5 6 7 11");
  const found = tree.branches(tree.get(2), new Set(path.map((s) => s.id)));
  check(
    "both ends of a branch that forks",
    found.map((b) => `${b.tip.id}:${b.strokes}`).join() === "9:2,10:2" && tree.forked,
  );
  check(
    "the nearest earlier picture",
    [1, 3, 4, 7, 11, 9].map((id) => tree.get(id).picture).join() === "0,0,4,4,4,0",
  );
  tree.setPictured(2);
  check(
    "a new one stands for what follows it",
    [1, 2, 3, 4, 7, 9].map((id) => tree.get(id).picture).join() === "0,2,2,4,4,2",
  );
  // At a fork, redo follows the branch from which the user came.
  tree.setHead(2);
  check("redo's way", tree.path().at(-1).id === 11);
  tree.setHead(9);
  tree.setHead(2);
  check("redo's way after another branch", tree.path().at(-1).id === 9);
}

async function oneCamera() {
  const pictureOf = (page) =>
    page.evaluate(async () =>
      [...new Uint8Array(await (await window.kibori.thumbnail()).arrayBuffer())].join(),
    );
  const studio = await Studio.start(join(folder, "camera.kibori"));
  const page = await open({ width: 900, height: 560 }, { draws: true });
  await enter(page, studio.url);
  const first = await shown(page);
  const eye = await page.evaluate(() => window.kibori.eye());
  const whole = await pictureOf(page);
  check(
    "a thumbnail leaves the view alone",
    (await page.evaluate(() => window.kibori.eye())).join() === eye.join(),
  );
  await lookBy(page, "3");
  check(
    "another view",
    Math.hypot(...(await page.evaluate(() => window.kibori.eye())).map((v, i) => v - eye[i])) > 10,
  );
  check("the same picture from another view", (await pictureOf(page)) === whole);
  await page.keyboard.press("Home");
  // A plot without any force does not draw until there is a force.
  await page.evaluate(() => {
    const context = document.querySelector("#plot canvas").getContext("2d"),
      clear = context.clearRect.bind(context);
    window.plotted = 0;
    context.clearRect = (...box) => {
      window.plotted++;
      clear(...box);
    };
  });
  const plotted = () => page.evaluate(() => window.plotted);
  let resting = -1;
  await eventually("the plot rests", async () => {
    resting = await plotted();
    await reports(page, 10);
    return (await plotted()) === resting;
  });
  await page.mouse.move(500, 240);
  await page.mouse.down();
  for (let i = 0; i < 12; i++) await page.mouse.move(500 + 4 * i, 240 - i);
  await until(page, "the volume falls", (s) => Number(s.volume) < Number(first.volume) - 1);
  await page.mouse.up();
  await eventually("the plot shows the force", async () => (await plotted()) > resting);
  await until(page, "a step", (s) => Number(s.step) > 1);
  // At rest, the picture is drawn, shown and stored.
  await page.locator("#history [aria-current] .shown:not(.earlier) img").waitFor();
  const now = (await state(page)).step;
  const kept = await eventually("the picture is kept", async () =>
    [...(await fetched(page, `/thumbnail?step=${now}`))].join(),
  );
  check("another picture of another state", (await pictureOf(page)) !== whole);
  check("the one that is kept is of this camera", kept === (await pictureOf(page)));
  await show(page, "history-camera");
  await pressUntil(page, "Control+z", "undone", (s) => s.step === "1");
  await until(page, "the same state", (s) => s.hash === first.hash);
  await atRest(page);
  check("the same picture of the same state", (await pictureOf(page)) === whole);
  const corner = await page.evaluate(async () => {
    const canvas = document.createElement("canvas"),
      into = canvas.getContext("2d");
    into.drawImage(await createImageBitmap(await window.kibori.thumbnail()), 0, 0);
    return [into.getImageData(0, 0, 1, 1).data[3], into.getImageData(64, 48, 1, 1).data[3]];
  });
  check("it has no ground, and something on it", corner[0] === 0 && corner[1] === 255);
  await page.context().close();
  const dark = await open({ width: 640, height: 480 }, { colorScheme: "dark" });
  await enter(dark, await studio.another());
  await shown(dark);
  check("the same picture in the dark", (await pictureOf(dark)) === whole);
  // The texts of the plot.
  for (const words of ["magnitude of the force, N", "magnitude of the moment, N mm", "Fz, N"])
    check(
      `the legend says ${words}`,
      (await dark.locator("#plot .u-legend").textContent()).includes(words),
    );
  check(
    "a sentence on the model",
    /^Series: /.test(await dark.locator("#model-says").textContent()),
  );
  await inPopover(dark, "#model", (one) => one.selectOption("energy"));
  check(
    "a sentence on another model",
    /^Energy: /.test(await dark.locator("#model-says").textContent()),
  );
  await dark.context().close();
  check("the studio ends well", (await studio.end()) === 0);
}

// Moves in a block: four cuts and one path in the air. The tool changes every 200 moves.
function scene(moves) {
  const tools = [
    '{ shape = "ball", radius = 1 }',
    '{ shape = "flat", radius = 1, length = 20 }',
    '{ shape = "cone", angle_deg = 90, radius = 3, length = 20 }',
  ];
  const out = [
    '[stock]\nblock = [60, 60, 10]\npitch = 1\n[tool]\nshape = "ball"\nradius = 1\n[force]\nmodel = "energy"\n[[move]]\nto = [2, 2, 14]',
  ];
  for (let i = 0; i < moves; i++) {
    const y = 2 + Math.floor(i / 50) * 0.9,
      x = 2 + (i % 50),
      air = i % 5 === 4;
    out.push(
      `[[move]]\nto = [${x}, ${y}, ${air ? 12 : 9.2}]\nmode = "${air ? "off" : "cut"}"\nspeed = 1000${i % 200 === 0 ? `\ntool = ${tools[(i / 200) % 3]}` : ""}${i === 10 ? '\nlabel = "groove"' : ""}`,
    );
  }
  return out.join("\n") + "\n";
}
// Branches of strokes without a tick, and times of a day's work. Documents may contain all of this.
const BRANCHES = `
import sqlite3, sys
db = sqlite3.connect(sys.argv[1])
count = db.execute("SELECT max(id) FROM step").fetchone()[0]
for i in range(1, count + 1):
    db.execute("UPDATE step SET made_at = strftime('%Y-%m-%dT%H:%M:%fZ', 1700000000 + 6 * ?, 'unixepoch') WHERE id = ?", (i, i))
for k in range(200):
    parent = count - 40 if k < 40 else 2 + (k - 40) * (count - 60) // 160
    for _ in range(1 + k % 3):
        db.execute("INSERT INTO step (parent, kind, setting, start, hash, finished, made_at) SELECT id, 'stroke', (SELECT setting FROM step WHERE id = 2), "
                   "(SELECT start FROM step WHERE id = 2), hash, 1, '2023-11-15T12:00:00Z' FROM step WHERE id = ?", (parent,))
        parent = db.execute("SELECT max(id) FROM step").fetchone()[0]
    if k == 199:
        db.execute("INSERT INTO version VALUES ('the last branch', ?)", (parent,))
db.execute("INSERT INTO version VALUES ('halfway', ?)", (count // 2,))
# Changes the document to a format without seals, because these rows have none.
# When the studio opens it, it adds the seals.
db.execute("DROP TABLE seal")
db.execute("DELETE FROM meta WHERE key NOT IN ('lattice', 'stock', 'program', 'head')")
db.execute("DROP TABLE bodies")
db.execute("DROP TABLE given")
db.execute("PRAGMA user_version = 4")
db.commit()
print(count)
`;

async function thousandsOfSteps() {
  const file = join(folder, "long.kibori");
  writeFileSync(join(folder, "long.toml"), scene(3000));
  execFileSync(kibori, ["carve", join(folder, "long.toml"), "-o", file], { stdio: "pipe" });
  const count = String(execFileSync("python3", ["-c", BRANCHES, file])).trim();
  check(`3000 steps (${count})`, Number(count) >= 3000);
  const studio = await Studio.start(file);
  const page = await open({ width: 1280, height: 720 });
  await enter(page, studio.url);
  await shown(page);
  await page.locator("#history [aria-current]").waitFor();
  // The visible part has cells without a gap, each with a picture or an icon, and words.
  const blanks = () =>
    page.evaluate(() => {
      const seen = document.querySelector("#history .scroller").getBoundingClientRect();
      const cells = [...document.querySelectorAll("#history .cells > button")]
        .map((cell) => ({ cell, box: cell.getBoundingClientRect() }))
        .filter(({ box }) => box.right > seen.left && box.left < seen.right);
      const wrong = cells.filter(
        ({ cell }) =>
          !cell.querySelector(".shown img, .shown svg") ||
          !cell.querySelector(".words").textContent.trim() ||
          !cell.title,
      ).length;
      let end = seen.left,
        gap = 0;
      for (const { box } of cells.sort((a, b) => a.box.left - b.box.left)) {
        gap = Math.max(gap, box.left - end);
        end = box.right;
      }
      const { scrollWidth, clientWidth } = document.querySelector("#history .scroller");
      if (scrollWidth > clientWidth) gap = Math.max(gap, seen.right - end);
      return {
        wrong,
        gap,
        cells: cells.length,
        all: document.querySelectorAll("#history .cells > button").length,
      };
    });
  const at = async (share) => {
    await page.evaluate((to) => {
      const box = document.querySelector("#history .scroller");
      box.scrollLeft = to * (box.scrollWidth - box.clientWidth);
    }, share);
    // The cells follow with the next frame, which may take a while on this machine.
    let found;
    await eventually(
      () => `nothing is blank at ${share}: ${JSON.stringify(found)}`,
      async () => {
        await frames(page);
        found = await blanks();
        return found.wrong === 0 && found.gap < 8 && found.cells > 2 && found.all < 60;
      },
    );
  };
  await show(page, "history-long");
  check(
    "the group with the present is open",
    (await page.locator("#history .step[aria-current]").count()) === 1,
  );
  for (const share of [1, 0.7, 0.31, 0]) await at(share);
  await show(page, "history-begin");

  // A named step ends its group, so a closed group shows this name.
  check(
    "a version's name ends its group",
    await page.evaluate(async () => {
      const box = document.querySelector("#history .scroller");
      for (let at = 0; at < box.scrollWidth; at += box.clientWidth / 2) {
        box.scrollLeft = at;
        await new Promise((done) => setTimeout(done, 60));
        if (document.querySelector("#history .named .name")?.textContent === "halfway") return true;
      }
      return false;
    }),
  );

  // By keys: to the first cell, along to a group, open it, go into it, and close it.
  const focused = () =>
    page.evaluate(() => ({
      ...document.activeElement.dataset,
      expanded: document.activeElement.getAttribute("aria-expanded"),
      title: document.activeElement.title,
    }));
  await at(0);
  await page.locator("#history [data-key='step 1']").focus();
  await page.keyboard.press("End");
  check(
    "End goes to the last cell",
    Number((await focused()).step) === Number(count) || (await focused()).key.startsWith("step"),
  );
  await page.keyboard.press("Home");
  check("Home goes to the stock", (await focused()).step === "1");
  await page.keyboard.press("ArrowRight");
  const group = await focused();
  check(
    `a group says its tool and strokes: ${group.title}`,
    group.expanded === "false" && /^Ball burr 1 mm: \d+ strokes, /.test(group.title),
  );
  await page.keyboard.press("Enter");
  await page.locator(`#history [data-key="${group.key}"][aria-expanded=true]`).waitFor();
  await page.keyboard.press("ArrowRight");
  check("it opens into its steps", (await focused()).key === "step 2");
  for (let i = 0; i < 8; i++) await page.keyboard.press("ArrowRight");
  check(
    "a step has its label",
    /groove/.test(
      await page.locator("#history .cells > button", { hasText: "groove" }).getAttribute("title"),
    ),
  );
  await show(page, "history-open");
  for (const share of [0.02, 0.01, 0]) await at(share);
  await page.locator("#history [data-key='step 1']").focus();
  await page.keyboard.press("Home");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Enter");
  await page.locator(`#history [data-key="${group.key}"][aria-expanded=false]`).waitFor();
  check(
    "the Tab key reaches one cell only",
    (await page.locator("#history .cells [tabindex='0']").count()) === 1,
  );

  // Branches: dots above the cells, by keys and by click.
  await page.keyboard.press("ArrowUp");
  const branch = await page.evaluate(() => ({
    tip: document.activeElement.dataset.tip,
    role: document.activeElement.getAttribute("role"),
    title: document.activeElement.querySelector("title")?.textContent,
  }));
  check(
    `a branch says what it is: ${branch.title}`,
    branch.role === "button" && /Branch.*stroke.*go to its end/.test(branch.title),
  );
  await page.keyboard.press("Enter");
  await until(page, "the branch's end", (s) => s.step === branch.tip);
  await page.locator(`#history [aria-current][data-step="${branch.tip}"]`).waitFor();
  await show(page, "history-branch");
  // The path has changed, and the former path is now a branch.
  await page.locator("#history [aria-current]").focus();
  await page.keyboard.press("Home");
  const dots = await page.locator("#history .branch").count();
  check(`branches are there (${dots})`, dots > 0);
  const back = page.locator("#history .branch[data-tip]").first();
  const tip = await back.getAttribute("data-tip");
  await back.click();
  await until(page, "where a dot leads", (s) => s.step === tip);
  await page.context().close();
  check("the studio ends well", (await studio.end()) === 0);
  execFileSync(kibori, ["verify", file]);
}

/** A page follows a file that another process replaces or writes, and keeps its camera. */
async function whatOthersCarve() {
  const file = join(folder, "live.kibori");
  const carved = (name, moves) => {
    writeFileSync(
      join(folder, `${name}.toml`),
      `[stock]\nblock = [40, 30, 20]\npitch = 0.5\n[tool]\nshape = "ball"\nradius = 4\n[[move]]\nto = [-6, 15, 18]\n${moves}`,
    );
    const made = join(folder, `${name}.kibori`);
    execFileSync(kibori, ["carve", join(folder, `${name}.toml`), "-o", made], { stdio: "ignore" });
    return made;
  };
  renameSync(carved("first", "[[move]]\nto = [20, 15, 18]\nspeed = 200\n"), file);
  const studio = await Studio.start(file, "--read-only", "--follow");
  const page = await open({ width: 900, height: 560 });
  await enter(page, studio.url);
  const before = await shown(page);
  await lookBy(page, "3");
  const eye = await page.evaluate(() => window.kibori.eye());
  await show(page, "live-before");
  renameSync(
    carved(
      "second",
      "[[move]]\nto = [46, 15, 18]\nspeed = 200\n[[move]]\nto = [46, 8, 15]\nspeed = 200\n[[move]]\nto = [-6, 8, 15]\nspeed = 200\n",
    ),
    file,
  );
  await until(page, "more is gone", (s) => Number(s.volume) < Number(before.volume) - 1000);
  const now = await shown(page);
  await show(page, "live-after");
  check(
    "seen from the same place",
    (await page.evaluate(() => window.kibori.eye())).join() === eye.join(),
  );
  // The page follows a document while a servo writes it.
  const written = join(folder, "written.kibori");
  const servo = spawn(kibori, ["servo", "--seconds", "12", "--no-surface", "-o", written], {
    stdio: "ignore",
  });
  await eventually("the servo writes", () => existsSync(written));
  const second = await Studio.start(written, "--read-only", "--follow");
  await enter(page, second.url);
  const begun = await shown(page);
  await until(page, "a stroke grows", (s) => Number(s.volume) < Number(begun.volume) - 5);
  servo.kill("SIGINT");
  await page.context().close();
  check(
    "both end well",
    (await studio.end()) === 0 && (await second.end()) === 0 && now.hash !== before.hash,
  );
}

await run([whatOthersCarve, scalesOfPlots, theTreeOfSteps, oneCamera, thousandsOfSteps]);
