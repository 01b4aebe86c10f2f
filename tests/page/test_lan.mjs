// SPDX-License-Identifier: MIT
// A phone pairs with the studio over the network and carves by touch. The phone is a browser window
// of its size, and the network is the loopback address 127.0.0.2. Usage: as test_studio.mjs
import { readFileSync } from "node:fs";
import { join } from "node:path";
import {
  Studio,
  check,
  enter,
  eventually,
  folder,
  frames,
  open,
  pace,
  run,
  show,
  shown,
  until,
} from "./harness.mjs";

const PHONE = { width: 390, height: 844 };
const TOUCH = { hasTouch: true, isMobile: true, ignoreHTTPSErrors: true };
const axe = readFileSync(
  new URL("../../web/node_modules/axe-core/axe.min.js", import.meta.url),
  "utf8",
);

/** The terminal's newest code. */
const codeOf = (studio) =>
  studio.printed
    .match(/Code to pair .*: (\S{3}) (\S{3})\n/g)
    ?.at(-1)
    .trim()
    .slice(-7);
const addressOf = (studio) =>
  eventually("the terminal shows a code", async () =>
    codeOf(studio) ? /https:\S+/.exec(studio.printed)[0] : null,
  );

async function pairsAndCarves() {
  const lan = ["--lan", "--lan-address", "127.0.0.2", "--lan-port", "0"];
  const studio = await Studio.start(join(folder, "tablet.kibori"), ...lan);
  const address = await addressOf(studio);
  const page = await open(PHONE, { ...TOUCH, bypassCSP: true });
  for (const colorScheme of ["dark", "light"]) {
    await page.emulateMedia({ colorScheme });
    await page.goto(address);
    await page.locator("#code").waitFor();
    await page.evaluate(axe);
    const faults = await page.evaluate(async () =>
      (await window.axe.run()).violations.map((fault) => `${fault.id}: ${fault.help}`),
    );
    check(`the page to pair is accessible: ${faults.join("; ")}`, faults.length === 0);
    await show(page, `lan-pair-${colorScheme}`);
  }
  const places = await page.evaluate(() =>
    [...document.querySelectorAll("#pairing :is(h1, label, input, button, p)")].map((one) => ({
      text: one.textContent || one.id,
      right: one.getBoundingClientRect().right,
      size: parseFloat(getComputedStyle(one).fontSize),
    })),
  );
  for (const { text, right, size } of places)
    check(`"${text}" is readable on a phone`, right <= PHONE.width && size >= 15);
  check("no text is missing", !(await page.locator("body").textContent()).includes("{{"));

  // A wrong code gives a message. Then enter the right code in lower case.
  const code = codeOf(studio);
  await page.locator("#code").fill("222 222");
  await page.locator("#pair button").tap();
  await page.locator("#pair-answer", { hasText: "not the code" }).waitFor();
  await show(page, "lan-wrong");
  await page.locator("#code").fill(code.toLowerCase());
  await page.locator("#pair button").tap();
  await page.locator("#left").waitFor({ state: "attached" }); // the page that carves is loaded
  const first = await shown(page);
  const cookies = await page.context().cookies();
  check("one cookie", cookies.length === 1);
  const [cookie] = cookies;
  check(
    "it is closed to scripts and other sites",
    cookie.httpOnly && cookie.secure && cookie.sameSite === "Strict",
  );
  check("no script sees it", (await page.evaluate(() => document.cookie)) === "");
  check(
    "no key is stored",
    (await page.evaluate(() => localStorage.getItem("kibori-key"))) === null,
  );

  // One stroke of a finger.
  const finger = await page.context().newCDPSession(page);
  const touch = (type, x, y) =>
    finger.send("Input.dispatchTouchEvent", {
      type,
      touchPoints: type === "touchEnd" ? [] : [{ x, y }],
    });
  const at = await page.evaluate(() => {
    for (let y = 200; y < 700; y += 10)
      if (window.kibori.onPiece(195, y) && window.kibori.onPiece(195, y + 40)) return y + 20;
    return 0;
  });
  check("the piece is there", at > 0);
  await touch("touchStart", 175, at);
  for (let i = 1; i <= 12; i++) {
    await touch("touchMove", 175 + 4 * i, at);
    await pace(page, 30);
  }
  await touch("touchEnd");
  await frames(page);
  await until(
    page,
    "a finger's cut",
    (s) => Number(s.step) > Number(first.step) && Number(s.volume) < Number(first.volume),
  );
  await show(page, "lan-carved");

  // The window on this machine watches the same piece. A reload needs no code.
  const local = await open({ width: 1280, height: 720 });
  await enter(local, studio.url);
  await until(local, "the same step", (s) => Number(s.step) > Number(first.step));
  await local.locator("#watching").waitFor();
  await page.reload();
  await shown(page);
  check("no second code", studio.printed.match(/Code to pair/g).length === 1);
  await local.context().close();
  check("the studio ends well", (await studio.end()) === 0);

  // The next studio does not know this phone. The page asks for a code.
  const port = new URL(address).port;
  const again = await Studio.start(
    join(folder, "tablet.kibori"),
    ...["--lan", "--lan-address", "127.0.0.2", "--lan-port", port],
  );
  await page.locator("#code").waitFor();
  await addressOf(again);
  await page.locator("#code").fill(codeOf(again));
  await page.locator("#code").press("Enter");
  await page.locator("#left").waitFor({ state: "attached" });
  await shown(page);
  await page.context().close();
  check("the next studio ends well", (await again.end()) === 0);
}

await run([pairsAndCarves]);
