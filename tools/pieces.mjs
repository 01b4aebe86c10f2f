// SPDX-License-Identifier: MIT
// Carves three pieces through the page alone, by pen strokes: a bowl, a relief with letters, an
// owl.
//
//     node tools/pieces.mjs KIBORI OUT_FOLDER [bowl|relief|figure ...]
//
// Each shape is a signed distance. The ball moves down along the line of sight until it touches the
// shape. Its position gives the point of the window and the pen's pressure. Depth is measured from
// a fixed plane ("Plane that you set"). The tool points along the view, and the view is
// orthographic. So a pen can reach any position exactly.
//
// Writes NAME.png, NAME.kibori, NAME.stl and NAME-forces.csv to OUT_FOLDER, and figure-page.png of
// the whole page. It fails if a piece is not one body. The pictures of docs/ are made by: pngquant
// --force --speed 1 --output docs/NAME.png 256 NAME.png
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import {
  check,
  drawn,
  enter,
  eventually,
  frames,
  hover,
  kibori,
  open,
  pace,
  pictures as out,
  run,
  shown,
  started,
  state,
  steady,
  Studio,
  until,
  whole,
} from "../tests/page/harness.mjs";

const SIZE = { width: 1280, height: 800 };
const SPEED = 300; // of a pen [mm/s]
const AT_ONCE = 400; // max number of pending events to the browser
const PICTURE = { width: 1200, height: 800 };

// ---- Vectors

const add = (a, b, k = 1) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];
const minus = (a, b) => add(a, b, -1);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const length = (a) => Math.hypot(...a);
const unit = (a) => a.map((x) => x / length(a));
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));
const mix = (a, b, t) => a + t * (b - a);
/** The minimum of two distances, rounded where they are almost equal. */
const smoothMin = (a, b, k) => {
  const h = Math.max(k - Math.abs(a - b), 0) / k;
  return Math.min(a, b) - (h * h * k) / 4;
};
const smoothMax = (a, b, k) => -smoothMin(-a, -b, k);

// ---- The studio, as a user operates it

export class Bench {
  clock = 0;
  events = 0;
  strokes = 0;

  /** Begins a new piece. `stock`: 0 block, 1 log, 2 ball. */
  static async begin(name, { stock, wood, long, detail }) {
    const bench = new Bench();
    bench.name = name;
    bench.studio = await Studio.start();
    process.on("exit", () => bench.studio.process.kill()); // also after an error
    const page = (bench.page = await open(SIZE, { acceptDownloads: true }));
    await enter(page, bench.studio.url);
    await started(page);
    await page.locator(`input[name=stock][value="${stock}"]`).check();
    await page.locator("#wood").selectOption({ label: wood });
    await page.locator("#length").fill(String(long));
    await page.locator("#detail").selectOption(String(detail));
    await page.locator("#name").fill(name);
    await page.locator("#go").click();
    bench.first = await shown(page);
    bench.middle = await page.evaluate(() => window.kibori.middle());
    bench.cdp = await page.context().newCDPSession(page);
    await page.locator("#axis").selectOption("view");
    await page.locator("#depth-from").selectOption("set");
    await page.locator("#view").focus();
    await page.keyboard.press("5");
    return bench;
  }

  /** Looks from a direction of the view cube. Each component is -1, 0 or 1. */
  async look(from) {
    const { page } = this;
    await page.evaluate(() => window.kibori.still(false));
    await page.locator("#view").focus();
    await page.keyboard.press("Home");
    await frames(page);
    const names = [
      ["Left", "Right"],
      ["Front", "Back"],
      ["Bottom", "Top"],
    ];
    const line = [2, 1, 0]
      .map((i) => (from[i] === 0 ? "" : names[i][from[i] > 0 ? 1 : 0]))
      .filter((word) => word);
    const title = `${line.join(" ")} view`;
    await page.evaluate(
      (wanted) => document.querySelector(`#cube button[title="${wanted}"]`).click(),
      title,
    );
    await page.locator("#view").focus();
    const turned = async () => {
      const [eye, about] = await page.evaluate(() => [window.kibori.eye(), window.kibori.middle()]);
      this.axis = unit(minus(eye, about));
      return dot(this.axis, unit(from)) > 0.9999;
    };
    await eventually(`the cube turns to '${title}'`, turned);
    await drawn(page);
    await turned();
    // Do not draw while carving. It would only take time.
    await page.evaluate(() => window.kibori.still(true));
    const places = [
      [0, 0, 0],
      [10, 0, 0],
      [0, 10, 0],
      [0, 0, 10],
    ].map((place) => add(this.middle, place));
    const seen = await page.evaluate(
      (all) => all.map((place) => window.kibori.onScreen(place)),
      places,
    );
    this.onto = seen.map((one, i) =>
      i === 0 ? [one.x, one.y] : [(one.x - seen[0].x) / 10, (one.y - seen[0].y) / 10],
    );
    // The view's directions to the right and up.
    this.across = unit(cross(Math.abs(this.axis[2]) > 0.99 ? [0, 1, 0] : [0, 0, 1], this.axis));
    this.up = cross(this.axis, this.across);
  }
  /** Where the window shows a position relative to the middle of the piece. */
  onScreen([x, y, z]) {
    const [o, a, b, c] = this.onto;
    return { x: o[0] + x * a[0] + y * b[0] + z * c[0], y: o[1] + x * a[1] + y * b[1] + z * c[1] };
  }

  async choose({ tool = "Ball burr", radius, angle }) {
    const { page } = this;
    await page.locator(`#shapes input[aria-label="${tool}"]`).check({ force: true });
    await this.type("size", radius);
    if (angle) await this.type("form", angle);
    this.radius = radius;
  }
  async type(id, value) {
    await this.page.locator(`#${id}-typed`).fill(String(value));
    await this.page.keyboard.press("Enter");
    const now = Number(await this.page.locator(`#${id}-typed`).inputValue());
    check(`${id} is ${value}, not ${now}`, Math.abs(now - value) < 0.006);
  }

  /** Measures depth from the visible wood at a position. */
  async setPlane(place) {
    const { page } = this,
      { x, y } = this.onScreen(place);
    await whole(page);
    await hover(page, x, y);
    const hit = await page.evaluate(([a, b]) => window.kibori.hit(a, b), [x, y]);
    check(
      `there is wood at ${place}: ${JSON.stringify(hit)}`,
      hit !== null && length(minus(minus(hit.point, this.middle), place)) < 0.5,
    );
    await page.locator("#view").focus();
    await page.keyboard.press("p");
    this.plane = { point: minus(hit.point, this.middle), normal: hit.normal };
    check("the plane faces who looks", dot(this.plane.normal, this.axis) > 0.2);
  }

  /** Pen strokes. Each is a list of tips relative to the middle of the piece. */
  async carve(strokes) {
    const { page, plane } = this;
    const deep = (tip) => dot(minus(plane.point, tip), plane.normal) / dot(this.axis, plane.normal);
    let deepest = 0.5;
    for (const stroke of strokes) for (const tip of stroke) deepest = Math.max(deepest, deep(tip));
    const depth = Math.ceil(5.1 * deepest) / 10;
    await this.type("depth", depth);
    await page.locator("#view").focus();
    await page.keyboard.down("b"); // a stroke may begin outside the wood
    const before = await state(page);
    const waiting = [];
    const send = (type, tip, buttons) => {
      const { x, y } = this.onScreen(tip),
        force = clamp(deep(tip) / (2 * depth), 1e-6, 1);
      const event = {
        type,
        x,
        y,
        button: "left",
        buttons,
        clickCount: 1,
        timestamp: this.clock,
        pointerType: "pen",
        force,
      };
      waiting.push(this.cdp.send("Input.dispatchMouseEvent", event));
      this.events++;
    };
    for (const stroke of strokes) {
      if (stroke.length < 2) continue;
      this.clock = Math.max(this.clock + 0.05, Date.now() / 1000);
      send("mousePressed", stroke[0], 1);
      for (let i = 1; i < stroke.length; i++) {
        const direction = minus(stroke[i], stroke[i - 1]),
          far = length(direction),
          parts = Math.max(1, Math.ceil(far / (0.08 * SPEED)));
        for (let k = 1; k <= parts; k++) {
          this.clock += Math.max(0.001, far / parts / SPEED);
          send("mouseMoved", add(stroke[i - 1], direction, k / parts), 1);
        }
        if (waiting.length >= AT_ONCE) await Promise.all(waiting.splice(0));
      }
      send("mouseReleased", stroke.at(-1), 0);
      await Promise.all(waiting.splice(0));
      this.strokes++;
    }
    await page.keyboard.up("b");
    // The next checks need a tool at rest. It rests when the last stroke has become a step.
    await until(
      page,
      "a step; was anything cut?",
      (s) => Number(s.step) > Number(before.step) && !/^0*$/.test(s.hash),
      60,
    );
    await steady(page, ({ step, volume }) => `${step} ${volume}`, 20);
    await whole(page);
    return state(page);
  }

  async settled() {
    const { page } = this;
    await page.evaluate(() => window.kibori.still(false));
    await drawn(page);
  }
  /** Turns the camera by arrow keys, from the initial perspective view. */
  async setView(keys) {
    const { page } = this;
    await page.evaluate(() => window.kibori.still(false));
    await page.locator("#view").focus();
    await page.keyboard.press("5");
    await page.keyboard.press("Home");
    await drawn(page);
    for (const key of keys) {
      await page.keyboard.press(key);
      await frames(page);
    }
    await this.settled();
  }
  /** Sets the light by its widget, -1 to 1 to the right and up. */
  async light(right, up) {
    const { page } = this;
    await page.locator("#look-box > summary").click();
    const { x, y, width, height } = await page.locator("#light").boundingBox();
    await page.mouse.click(x + (width * (1 + right)) / 2, y + (height * (1 - up)) / 2);
    await page.locator("#look-box > summary").click();
    await page.mouse.move(SIZE.width / 3, 20);
    await this.settled();
  }
  /**
   * Takes a picture of the whole page during a stroke along some positions. Then undoes the stroke.
   */
  async pictureOfPage(places, depth) {
    const { page } = this,
      { hash, step } = await state(page);
    await page.locator("#axis").selectOption("normal");
    await page.locator("#depth-from").selectOption("began");
    await this.type("depth", depth);
    const there = places.map((place) => add(this.middle, place));
    const seen = await page.evaluate(
      (all) => all.map((place) => window.kibori.onScreen(place)),
      there,
    );
    await page.mouse.move(seen[0].x, seen[0].y);
    await page.mouse.down();
    for (const { x, y } of seen) {
      await page.mouse.move(x, y);
      await pace(page, 60);
    }
    await pace(page, 1500);
    await page.screenshot({ path: join(out, `${this.name}-page.png`) });
    await page.mouse.up();
    await until(page, "a step", (s) => s.step !== step && !/^0*$/.test(s.hash), 60);
    await page.locator("#view").focus();
    await page.keyboard.press("Control+z");
    await until(page, "undone", (s) => s.hash === hash, 60);
  }
  async download(press, name) {
    const [file] = await Promise.all([
      this.page.waitForEvent("download", { timeout: 300000 }),
      press(),
    ]);
    await file.saveAs(join(out, name));
  }
  async picture(name = this.name) {
    const { page } = this;
    await page.locator("#look-box > summary").click();
    await page.locator("#picture").click();
    await page.locator("#capture-width").fill(String(PICTURE.width));
    await page.locator("#capture-height").fill(String(PICTURE.height));
    await this.download(() => page.locator("#capture-save").click(), `${name}.png`);
    await page.locator("#look-box > summary").click();
  }
  async export(format, name) {
    const { page } = this;
    await page.locator("#export").click();
    await page.locator("#format").selectOption(format);
    await this.download(() => page.locator("#exporting button.main").click(), name);
  }

  /** Saves the forces of the last ten minutes. */
  async forces(of = this.name) {
    const { page, name } = this,
      file = `${of}-forces.csv`;
    await this.download(() => page.locator("#csv").click(), file);
    const [head, ...rows] = readFileSync(join(out, file), "utf8").trim().split("\n");
    const at = ["fx_n", "fy_n", "fz_n"].map((title) => head.split(",").indexOf(title));
    const sizes = rows
      .map((row) => Math.hypot(...at.map((i) => Number(row.split(",")[i]))))
      .filter((f) => f > 0.01)
      .sort((a, b) => a - b);
    const share = (p) => (sizes[Math.floor(p * (sizes.length - 1))] ?? 0).toFixed(1);
    const line = `median ${share(0.5)}, 95 % ${share(0.95)}, most ${share(1)} N`;
    console.log(`${name}: forces in ${file}, of ${sizes.length} ticks that cut: ${line}`);
  }

  /**
   * Compares the result with the intended shape: one body, its volume, and its surface's distance
   * from the shape.
   */
  async judge(meant, distance) {
    const { page, name } = this,
      made = Number((await state(page)).volume);
    await this.forces();
    await this.export("kibori", `${name}.kibori`);
    await this.export("stl", `${name}.stl`);
    console.log(execFileSync(kibori, ["info", join(out, `${name}.kibori`)], { encoding: "utf8" }));
    const { bodies, vertices } = readStl(join(out, `${name}.stl`));
    const off = vertices.map((place) => distance(minus(place, this.middle))).sort((a, b) => a - b);
    const at = (p) => off[Math.floor(p * (off.length - 1))].toFixed(3);
    console.log(
      `${name}: ${made.toFixed(0)} mm³ of ${meant.toFixed(0)} meant (${((100 * made) / meant - 100).toFixed(2)} %), ` +
        `bodies of ${bodies.join(", ")} triangles; ` +
        `surface off by ${[0, 0.01, 0.05, 0.5, 0.95, 0.99, 1].map(at).join(", ")} mm (least, 1 %, 5 %, median, 95 %, 99 %, most)`,
    );
    console.log(`${name}: ${this.strokes} strokes of ${this.events} events`);
    // Undo and redo restore the same bytes.
    const { hash } = await state(page);
    await page.locator("#view").focus();
    await page.keyboard.press("Control+z");
    await until(page, "undone", (s) => s.hash !== hash && !/^0*$/.test(s.hash), 60);
    await page.keyboard.press("Control+y");
    await until(page, "done again", (s) => s.hash === hash, 60);
    check(`${name} is one body`, bodies.length === 1);
  }
  async end() {
    await this.page.context().close();
    check("the studio ends well", (await this.studio.end()) === 0);
  }
}

/** The number of triangles of each body, and some of the vertices. */
function readStl(path) {
  const bytes = readFileSync(path),
    count = bytes.readUInt32LE(80),
    ids = new Map(),
    parent = [],
    corner = new Int32Array(3 * count);
  const root = (i) => {
    while (parent[i] !== i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const vertices = [];
  for (let i = 0; i < count; i++) {
    for (let k = 0; k < 3; k++) {
      const from = 84 + 50 * i + 12 + 12 * k,
        key = bytes.toString("latin1", from, from + 12);
      let id = ids.get(key);
      if (id === undefined) {
        ids.set(key, (id = parent.length));
        parent.push(id);
        if (id % 16 === 0) vertices.push([0, 4, 8].map((step) => bytes.readFloatLE(from + step)));
      }
      corner[3 * i + k] = id;
      if (k > 0) parent[root(id)] = root(corner[3 * i]);
    }
  }
  const bodies = new Map();
  for (let i = 0; i < count; i++)
    bodies.set(root(corner[3 * i]), (bodies.get(root(corner[3 * i])) ?? 0) + 1);
  return { bodies: [...bodies.values()].sort((a, b) => b - a), vertices };
}

/** The volume of a shape in a box about the origin, by samples. `half` is half the box's size. */
function volumeOf(distance, half, step) {
  let sum = 0;
  for (let x = -half[0] + step / 2; x < half[0]; x += step)
    for (let y = -half[1] + step / 2; y < half[1]; y += step)
      for (let z = -half[2] + step / 2; z < half[2]; z += step)
        sum += clamp(0.5 - distance([x, y, z]) / step, 0, 1);
  return sum * step ** 3;
}

// ---- Paths

/** Removes points within a tolerance of the segments between the remaining ones. */
function simplified(path, tolerance) {
  const keep = new Uint8Array(path.length),
    ranges = [[0, path.length - 1]];
  keep[0] = keep[path.length - 1] = 1;
  while (ranges.length > 0) {
    const [from, to] = ranges.pop(),
      direction = minus(path[to], path[from]),
      long = dot(direction, direction) || 1e-12;
    let largest = tolerance,
      at = -1;
    for (let i = from + 1; i < to; i++) {
      const off = minus(path[i], path[from]),
        away = length(add(off, direction, -clamp(dot(off, direction) / long, 0, 1)));
      if (away > largest) [largest, at] = [away, i];
    }
    if (at < 0) continue;
    keep[at] = 1;
    ranges.push([from, at], [at, to]);
  }
  return path.filter((_, i) => keep[i]);
}

/**
 * The height along the view, from the plane through the middle, where a descending ball touches the
 * shape. It is at least `floor`.
 */
function drop(bench, distance, radius, place, { allowance = 0, from, floor }) {
  const { axis } = bench,
    clear = radius + allowance;
  let high = from;
  for (;;) {
    const off = distance(add(place, axis, high + radius)) - clear;
    if (off < 0.005) return high;
    high -= Math.max(0.01, 0.8 * off);
    if (high <= floor) return floor;
  }
}

/**
 * A zigzag path over a rectangle of the view: `wide` by `high`, with its centre at `about`. `apart`
 * is the distance of rows. `layer` is the max depth of one pass. Rows that remove nothing are left
 * out. Each layer is one stroke.
 */
function raster(bench, distance, how) {
  const {
    about = [0, 0, 0],
    wide,
    high,
    apart,
    along = 0.3,
    radius,
    allowance = 0,
    from,
    floor,
    layer = 0,
    tolerance = 0.01,
  } = how;
  const { axis, across, up } = bench,
    rows = [],
    middle = minus(
      about,
      axis.map((x) => x * dot(about, axis)),
    );
  const count = Math.ceil(high / apart),
    steps = Math.ceil(wide / along);
  for (let i = 0; i <= count; i++) {
    const row = [];
    for (let k = 0; k <= steps; k++) {
      const place = add(
        add(middle, across, (k / steps - 0.5) * wide),
        up,
        (i / count - 0.5) * high,
      );
      row.push({ place, deep: drop(bench, distance, radius, place, { allowance, from, floor }) });
    }
    rows.push(row);
  }
  const strokes = [];
  for (let top = from; top > floor; top -= layer || Infinity) {
    const bottom = layer ? Math.max(floor, top - layer) : floor,
      path = [];
    rows.forEach((row) => {
      if (layer && !row.some(({ deep }) => deep < top - 0.01)) return;
      const tips = row.map(({ place, deep }) => add(place, axis, Math.max(deep, bottom)));
      path.push(...(Math.round(path.length / row.length) % 2 ? tips.reverse() : tips));
    });
    if (path.length > 1) strokes.push(simplified(path, tolerance));
  }
  return strokes;
}

/**
 * A spiral about the axis of the view, from outside in. The rings are equally spaced along the
 * surface. One stroke.
 */
function spiral(
  bench,
  distance,
  { outer, inner = 0.05, apart, along = 0.4, radius, from, floor, tolerance = 0.006 },
) {
  const { axis, across, up } = bench,
    path = [];
  const at = (r, angle) => {
    const place = add(add([0, 0, 0], across, r * Math.cos(angle)), up, r * Math.sin(angle));
    return add(place, axis, drop(bench, distance, radius, place, { from, floor }));
  };
  let r = outer,
    angle = 0,
    slope = 0,
    last = at(r, 0);
  while (r > inner) {
    path.push(last);
    const turn = Math.min(0.3, along / Math.max(r, 0.2));
    // Measures the slope half a ring further inwards.
    const here = dot(at(r, angle), axis),
      next = dot(at(Math.max(inner, r - apart / 2), angle), axis);
    slope = mix(slope, clamp(Math.abs(next - here) / (apart / 2), 0, 8), 0.1);
    angle += turn;
    r -= (apart / Math.hypot(1, slope)) * (turn / (2 * Math.PI));
    last = at(r, angle);
  }
  return [simplified(path, tolerance)];
}

// ---- Bowl

/**
 * The distance to a closed line in the plane, negative inside, and the position of the nearest
 * point on it.
 */
function polygon(points) {
  return (x, y) => {
    let near = Infinity,
      within = false,
      at = [0, 0];
    for (let i = 0, j = points.length - 1; i < points.length; j = i++) {
      const [ax, ay] = points[j],
        [bx, by] = points[i],
        ex = bx - ax,
        ey = by - ay,
        wx = x - ax,
        wy = y - ay;
      const t = clamp((wx * ex + wy * ey) / (ex * ex + ey * ey), 0, 1),
        dx = wx - t * ex,
        dy = wy - t * ey;
      if (dx * dx + dy * dy < near) [near, at] = [dx * dx + dy * dy, [x - dx, y - dy]];
      if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * ex) within = !within;
    }
    return [(within ? -1 : 1) * Math.sqrt(near), ...at];
  };
}

const FLUTES = 18,
  FLUTE = 1.1;
function bowlShape() {
  // The profile as radius and height: foot, outside, lip, inside.
  const foot = [
      [0, -13.6],
      [7.2, -13.6],
      [8.0, -14.9],
      [10.2, -14.9],
      [10.4, -12.9],
    ],
    outside = [],
    lip = [],
    inside = [];
  for (let i = 0; i <= 24; i++) {
    const a = (i / 48) * Math.PI;
    outside.push([10.4 + 13.4 * Math.sin(a) ** 0.95, -12.9 + 27.1 * (1 - Math.cos(a)) ** 0.92]);
    inside.push([21.4 * Math.sin(a), -9.6 + 23.8 * (1 - Math.cos(a)) ** 0.86]);
  }
  for (let i = 1; i < 8; i++)
    lip.push([22.6 + 1.2 * Math.cos((i * Math.PI) / 8), 14.2 + 0.75 * Math.sin((i * Math.PI) / 8)]);
  const plain = polygon([...foot, ...outside.slice(1), ...lip, ...inside.reverse()]);
  // Both profiles are distorted quarter circles. The mean of both is inside the wood.
  const turned = (share) => Math.sin(Math.acos(1 - clamp(share, 0, 1)));
  const between = (high) => {
    const outer = 10.4 + 13.4 * turned(Math.max(0, (high + 12.9) / 27.1) ** (1 / 0.92)) ** 0.95;
    return 0.5 * (outer + 21.4 * turned(Math.max(0, (high + 9.6) / 23.8) ** (1 / 0.86)));
  };
  return ([x, y, z]) => {
    const [base, r, high] = plain(Math.hypot(x, y), z);
    if (base > 9) return base - FLUTE;
    // Flutes like those of a gouge, slightly twisted. They fade below the lip and above the foot.
    const turn = (Math.atan2(y, x) / (2 * Math.PI)) * FLUTES + 0.022 * (high + 15),
      part = 2 * (turn - Math.round(turn));
    const end = Math.max(0, (high - 5.5) / 5, (-8.4 - high) / 3.2),
      deep = FLUTE * Math.max(0, 1 - part * part - end * end);
    return r > between(high) ? base + deep : base;
  };
}

async function bowl() {
  const bench = await Bench.begin("bowl", { stock: 0, wood: "oak", long: 80, detail: 512 }),
    shape = bowlShape(),
    lap = timer();
  // Carves the inside from above. Keeps material outside the opening and below the lip for later.
  const neighbour = ([x, y, z]) =>
    Math.hypot(Math.max(0, 23 - Math.hypot(x, y)), Math.max(0, z - 13.6));
  const hollow = (place) => Math.min(shape(place), neighbour(place));
  await bench.look([0, 0, 1]);
  await bench.setPlane([30, 0, 15]);
  await bench.choose({ radius: 5 });
  const room = { from: 15.2, floor: -15.6 };
  const inside = {
    ...room,
    wide: 46,
    high: 46,
    apart: 3.2,
    radius: 5,
    allowance: 0.5,
    layer: 4,
    tolerance: 0.08,
  };
  await bench.carve(raster(bench, hollow, inside));
  lap("inside, rough");
  await bench.choose({ radius: 4 });
  await bench.carve(spiral(bench, hollow, { ...room, outer: 27, apart: 0.45, radius: 4 }));
  lap("inside, fine");
  // Carves the outside from below.
  await bench.look([0, 0, -1]);
  await bench.setPlane([0, 0, -15]);
  await bench.choose({ radius: 6 });
  const outside = {
    ...room,
    wide: 84,
    high: 54,
    apart: 4,
    radius: 6,
    allowance: 0.4,
    layer: 4.5,
    tolerance: 0.08,
  };
  await bench.carve(raster(bench, shape, outside));
  await bench.choose({ radius: 3 });
  await bench.carve(
    raster(bench, shape, { ...outside, wide: 56, apart: 2, radius: 3, allowance: 0.25 }),
  );
  lap("outside, rough");
  await bench.choose({ radius: 2 });
  await bench.carve(
    spiral(bench, shape, { ...room, outer: 27, apart: 0.35, along: 0.3, radius: 2 }),
  );
  lap("outside, fine");
  await bench.setView(["+", "+", "+", "ArrowDown"]);
  await bench.light(-0.42, 0.4);
  await bench.picture();
  await bench.judge(volumeOf(shape, [25, 25, 15], 0.2), shape);
  await bench.end();
}

const timer = () => {
  let from = Date.now();
  return (what) => {
    console.log(`  ${what}: ${((Date.now() - from) / 1000).toFixed(1)} s`);
    from = Date.now();
  };
};
// ---- Relief

const GRID = 0.05; // of the drawing [mm]
const PANEL = { wide: 80, high: 50, top: 15, ground: 12.4, back: 1 };
/** The twig's leaves: where they begin, their direction [degrees], their length and width. */
const LEAVES = [];
const stemAt = (t) => [mix(-29, 22.5, t), 6.2 + 4.5 * Math.sin(2.6 * t - 0.5)];
for (let i = 0; i < 5; i++) {
  const t = 0.1 + 0.185 * i,
    size = 1 - 0.07 * i;
  LEAVES.push({ from: stemAt(t), turn: 52 - 6 * i, long: 14.5 * size, broad: 6.2 * size });
  LEAVES.push({ from: stemAt(t + 0.08), turn: -38 - 5 * i, long: 13 * size, broad: 5.8 * size });
}
LEAVES.push({ from: stemAt(0.985), turn: -8, long: 11, broad: 5 });

/**
 * Draws black on white in the browser. Returns signed distances [mm] on the grid, negative inside.
 */
async function drawing(page, { word, leaves, frame }) {
  const text = await page.evaluate(
    async ([panel, grid, letters, all, edge]) => {
      const canvas = new OffscreenCanvas(panel.wide / grid, panel.high / grid),
        c = canvas.getContext("2d", { willReadFrequently: true });
      c.fillStyle = "#fff";
      c.fillRect(0, 0, canvas.width, canvas.height);
      c.setTransform(1 / grid, 0, 0, -1 / grid, canvas.width / 2, canvas.height / 2);
      c.fillStyle = c.strokeStyle = "#000";
      if (edge) {
        c.fillRect(-panel.wide / 2, -panel.high / 2, panel.wide, panel.high);
        c.fillStyle = "#fff";
        c.beginPath();
        c.roundRect(
          -panel.wide / 2 + edge,
          -panel.high / 2 + edge,
          panel.wide - 2 * edge,
          panel.high - 2 * edge,
          2,
        );
        c.fill();
        c.fillStyle = "#000";
      }
      if (all) {
        c.lineCap = "round";
        c.lineWidth = 1.7;
        c.beginPath();
        all.stem.forEach(([x, y], i) => (i ? c.lineTo(x, y) : c.moveTo(x, y)));
        c.stroke();
        for (const { from, turn, long, broad } of all.leaves) {
          c.save();
          c.translate(...from);
          c.rotate((turn * Math.PI) / 180);
          c.beginPath();
          c.moveTo(0, 0);
          c.bezierCurveTo(0.3 * long, 0.75 * broad, 0.7 * long, 0.6 * broad, long, 0);
          c.bezierCurveTo(0.7 * long, -0.6 * broad, 0.3 * long, -0.75 * broad, 0, 0);
          c.fill();
          c.restore();
        }
      }
      if (letters) {
        c.scale(1, -1);
        c.font = "bold 13.5px 'DejaVu Serif'";
        c.letterSpacing = "1.6px";
        c.textAlign = "center";
        c.fillText(letters, 0.8, 16.6);
      }
      const data = c.getImageData(0, 0, canvas.width, canvas.height).data,
        bytes = new Uint8Array(data.length / 4);
      for (let i = 0; i < bytes.length; i++) bytes[i] = data[4 * i] < 128 ? 1 : 0;
      let line = "";
      for (let i = 0; i < bytes.length; i += 8192)
        line += String.fromCharCode(...bytes.subarray(i, i + 8192));
      return btoa(line);
    },
    [
      PANEL,
      GRID,
      word ?? "",
      leaves
        ? { leaves: LEAVES, stem: Array.from({ length: 41 }, (_, i) => stemAt(i / 41)) }
        : null,
      frame ?? 0,
    ],
  );
  const black = Buffer.from(text, "base64"),
    w = PANEL.wide / GRID,
    h = PANEL.high / GRID;
  const away = (of) =>
    squaredDistances(
      Float64Array.from(black, (b) => (b === of ? 0 : 1e12)),
      w,
      h,
    );
  const out = away(1),
    within = away(0);
  return Float64Array.from(
    out,
    (d, i) => GRID * (d > 0 ? Math.sqrt(d) - 0.5 : 0.5 - Math.sqrt(within[i])),
  );
}
/** Distances to the nearest zero by Felzenszwalb's parabolas: along columns, then rows. */
function squaredDistances(f, w, h) {
  const line = (n, at) => {
    const v = new Int32Array(n),
      z = new Float64Array(n + 1),
      g = Float64Array.from({ length: n }, (_, i) => f[at(i)]);
    let k = 0;
    z[0] = -Infinity;
    z[1] = Infinity;
    for (let q = 1; q < n; q++) {
      let s;
      do s = (g[q] + q * q - g[v[k]] - v[k] * v[k]) / (2 * (q - v[k]));
      while (s <= z[k] && --k >= 0);
      v[++k] = q;
      z[k] = s;
      z[k + 1] = Infinity;
    }
    k = 0;
    for (let q = 0; q < n; q++) {
      while (z[k + 1] < q) k++;
      f[at(q)] = (q - v[k]) ** 2 + g[v[k]];
    }
  };
  for (let x = 0; x < w; x++) line(h, (i) => i * w + x);
  for (let y = 0; y < h; y++) line(w, (i) => y * w + i);
  return f;
}
/** Interpolates on the drawing's grid. */
function reading(field) {
  const w = PANEL.wide / GRID,
    h = PANEL.high / GRID;
  return (x, y) => {
    const u = clamp((x + PANEL.wide / 2) / GRID - 0.5, 0, w - 1.001),
      v = clamp((PANEL.high / 2 - y) / GRID - 0.5, 0, h - 1.001);
    const i = Math.floor(u),
      k = Math.floor(v),
      a = u - i,
      b = v - k,
      at = k * w + i;
    return (
      (1 - b) * ((1 - a) * field[at] + a * field[at + 1]) +
      b * ((1 - a) * field[at + w] + a * field[at + w + 1])
    );
  };
}
/** The contour lines of a value, by marching squares: closed, or to the rim of the panel. */
function contours(value, level, step = 0.1) {
  const w = Math.round(PANEL.wide / step),
    h = Math.round(PANEL.high / step),
    f = new Float64Array((w + 1) * (h + 1));
  const place = (i, k) => [i * step - PANEL.wide / 2, k * step - PANEL.high / 2];
  for (let k = 0; k <= h; k++)
    for (let i = 0; i <= w; i++) f[k * (w + 1) + i] = value(...place(i, k)) - level || 1e-9;
  // The number of an edge is computed from its first node and its direction.
  const from = new Map();
  const cut = (i, k, direction) => 2 * (k * (w + 1) + i) + direction;
  for (let k = 0; k < h; k++)
    for (let i = 0; i < w; i++) {
      const corners = [
        [i, k],
        [i + 1, k],
        [i + 1, k + 1],
        [i, k + 1],
      ].map(([a, b]) => f[b * (w + 1) + a] < 0);
      const edges = [cut(i, k, 0), cut(i + 1, k, 1), cut(i, k + 1, 0), cut(i, k, 1)];
      const enter = [],
        leave = [];
      for (let e = 0; e < 4; e++) {
        const a = corners[e],
          b = corners[(e + 1) % 4];
        if (a && !b) leave.push(edges[e]);
        if (!a && b) enter.push(edges[e]);
      }
      enter.forEach((one, n) => from.set(one, leave[n]));
    }
  const point = (edge) => {
    const direction = edge & 1,
      node = edge >> 1,
      i = node % (w + 1),
      k = Math.floor(node / (w + 1));
    const a = f[node],
      b = f[node + (direction ? w + 1 : 1)],
      t = a / (a - b),
      [x, y] = place(i, k);
    return direction ? [x, y + t * step] : [x + t * step, y];
  };
  const lines = [],
    to = new Set(from.values());
  const starts = [...[...from.keys()].filter((edge) => !to.has(edge)), ...from.keys()];
  for (const start of starts) {
    if (!from.has(start)) continue;
    const line = [point(start)];
    for (let at = start; from.has(at); ) {
      const next = from.get(at);
      from.delete(at);
      line.push(point(next));
      at = next;
    }
    if (line.length > 8) lines.push(line);
  }
  return lines;
}

async function relief() {
  const bench = await Bench.begin("relief", { stock: 0, wood: "limewood", long: 80, detail: 512 }),
    lap = timer();
  const [hardGrid, leafGrid] = [
    await drawing(bench.page, { word: "KIBORI", frame: 4 }),
    await drawing(bench.page, { leaves: true }),
  ];
  const hard = reading(hardGrid),
    leaf = reading(leafGrid),
    any = (x, y) => Math.min(hard(x, y), leaf(x, y));
  const { top, ground, back } = PANEL,
    room = { from: top + 0.2, tolerance: 0.01 };
  const flat = (lines, z) =>
    lines.map((line) =>
      simplified(
        line.map(([x, y]) => [x, y, z]),
        0.006,
      ),
    );
  lap("drawn");
  // Remove the back, so that the block becomes a panel.
  await bench.look([0, 0, -1]);
  await bench.setPlane([0, 0, -15]);
  await bench.choose({ tool: "End mill", radius: 8 });
  await bench.carve(
    raster(bench, () => 1e3, {
      wide: 100,
      high: 66,
      apart: 11,
      along: 10,
      radius: 8,
      from: 15,
      floor: back,
      layer: 2.4,
    }),
  );
  lap("back");
  // The ground around the raised parts. An end mill leaves it flat.
  await bench.look([0, 0, 1]);
  await bench.setPlane([38, 0, 15]);
  await bench.choose({ tool: "End mill", radius: 2 });
  const rings = (radius, from, apart, until) => {
    const all = [];
    for (let d = from; d < until; d += apart) all.push(...contours(any, d));
    return flat(all, ground);
  };
  await bench.carve(rings(2, 2.15, 1.2, 12));
  lap("ground, rough");
  await bench.choose({ tool: "End mill", radius: 0.6 });
  await bench.carve(rings(0.6, 0.6, 0.3, 3.4));
  lap("ground, fine");
  // Leaves rise with the distance from their edge. A groove marks their middle.
  const veins = LEAVES.map(({ from: [x, y], turn, long }) => {
    const angle = (turn * Math.PI) / 180;
    return [
      [x, y],
      [x + long * Math.cos(angle), y + long * Math.sin(angle)],
    ];
  });
  const high = (x, y) => {
    const d = -leaf(x, y),
      h = hard(x, y);
    return h < 0
      ? top
      : d <= 0
        ? ground
        : ground + 0.8 + 1.7 * (1 - (1 - clamp(d / 2.6, 0, 1)) ** 2);
  };
  const RADIUS = 1.2;
  const over = (x, y) => {
    let largest = ground;
    for (let i = 0; i < 7; i++)
      for (let k = 0; k < 16; k++) {
        const r = (RADIUS * (i + (k % 2) / 2)) / 6.6,
          a = (k * Math.PI) / 8;
        largest = Math.max(
          largest,
          high(x + r * Math.cos(a), y + r * Math.sin(a)) +
            Math.sqrt(Math.max(0, RADIUS ** 2 - r * r)) -
            RADIUS,
        );
      }
    return largest;
  };
  await bench.choose({ radius: RADIUS });
  const domes = [],
    raised = (line) =>
      simplified(
        line.map(([x, y]) => [x, y, over(x, y)]),
        0.01,
      );
  for (let d = 0.5; d > -3.6; d -= 0.18) domes.push(...contours(leaf, d, 0.12).map(raised));
  await bench.carve(domes);
  lap("leaves");
  await bench.choose({ tool: "V cutter", radius: 2, angle: 70 });
  const grooves = veins.map(([a, b]) =>
    Array.from({ length: 25 }, (_, i) => {
      const t = mix(0.02, 0.93, i / 24),
        x = mix(a[0], b[0], t),
        y = mix(a[1], b[1], t);
      return [
        x,
        y,
        Math.min(high(x, y), ground + 2.5) -
          0.75 * Math.sin(Math.PI * Math.min(1, t + 0.25)) ** 0.7,
      ];
    }),
  );
  await bench.carve(grooves);
  lap("veins");
  // Edges of letters and frame, inside and outside.
  await bench.choose({ tool: "V cutter", radius: 2, angle: 90 });
  await bench.carve(flat(contours(hard, 0.03), top - 0.32));
  const rim = [
    [-40, -25],
    [40, -25],
    [40, 25],
    [-40, 25],
    [-40, -25],
    [-38, -25],
  ].map(([x, y]) => [1.0005 * x, 1.0005 * y, top - 1.1]);
  await bench.carve([rim]);
  lap("edges");
  await bench.setView(["+", "+", "ArrowUp", "ArrowUp", "ArrowUp", "ArrowLeft", "ArrowLeft"]);
  await bench.light(-0.5, 0.55);
  await bench.picture();
  let meant = 0;
  for (let x = -39.95; x < 40; x += 0.1)
    for (let y = -24.95; y < 25; y += 0.1) meant += 0.01 * (high(x, y) + back);
  const neighbour = ([x, y, z]) =>
    Math.min(
      Math.abs(z - high(x, y)),
      Math.abs(any(x, y)),
      Math.abs(z + back),
      40 - Math.abs(x),
      25 - Math.abs(y),
    );
  await bench.judge(meant, neighbour);
  await bench.end();
}

// ---- Owl

const ellipsoid = (p, c, r) => {
  const q = [(p[0] - c[0]) / r[0], (p[1] - c[1]) / r[1], (p[2] - c[2]) / r[2]],
    k = length(q);
  const g = Math.hypot(q[0] / r[0], q[1] / r[1], q[2] / r[2]);
  return k < 1e-6 ? -Math.min(...r) : (k * (k - 1)) / g;
};
/** A cone between two balls. */
const cone = (p, a, b, ra, rb) => {
  const direction = minus(b, a),
    off = minus(p, a),
    t = clamp(dot(off, direction) / dot(direction, direction), 0, 1);
  return length(add(off, direction, -t)) - mix(ra, rb, t);
};
/** Feathers like roof tiles, each over the one below. Returns their height, 0 to 1. */
function feathers(u, v, wide, high, reach) {
  const row = Math.floor(v / high);
  for (let k = row + 2; k >= row - 1; k--) {
    const shift = k & 1 ? 0.5 : 0,
      du = u - (Math.round(u / wide - shift) + shift) * wide,
      dv = v - k * high;
    const far = Math.hypot(du / (0.62 * wide), Math.min(0, dv) / reach);
    if (dv <= 0.5 * high && far < 1) return far ** 2.2 - 0.25 * Math.exp(-((du / 0.35) ** 2));
  }
  return 0;
}
const smoothstep = (low, high, x) => {
  const t = clamp((x - low) / (high - low), 0, 1);
  return t * t * (3 - 2 * t);
};
/** Left and right are symmetric. The face looks to the front, -y. */
function owlShape([px, y, z]) {
  const x = Math.abs(px),
    p = [x, y, z];
  // The rest of the log below the owl.
  const plinth = z + 33.5 + 0.02 * (x * x + y * y) * 0.1;
  const body = ellipsoid(p, [0, 0.5, -12], [14.6, 13.2, 25]),
    head = ellipsoid(p, [0, -0.8, 18.5], [14.2, 12.4, 12.2]);
  if (Math.min(body, head) > 20) return Math.min(plinth, Math.min(body, head) - 10);
  let d = smoothMin(body, head, 7);
  // Ears, and the brows from the beak to the ears.
  d = smoothMin(d, cone(p, [8, -2.5, 25], [12.6, -4, 36.2], 4.2, 0.9), 4);
  d = smoothMin(d, cone(p, [1.2, -13.6, 18.6], [10.6, -7.6, 29], 1.3, 1.9), 2.4);
  // The dishes of the face with eyes, and the beak.
  d = smoothMax(d, 8.6 - length(minus(p, [6.4, -19.6, 17.6])), 0.9);
  const face = Math.hypot(x - 6.2, z - 17.6);
  if (y < 0) d -= 0.45 * Math.exp(-(((face - 6.7) / 0.75) ** 2)) * smoothstep(2, -6, y);
  d = smoothMin(d, length(minus(p, [5.9, -10.0, 17.9])) - 3.5, 0.35);
  d = smoothMax(d, 1.7 - length(minus(p, [5.7, -14.1, 18.1])), 0.25);
  d = smoothMin(d, cone(p, [0, -13.2, 17.4], [0, -15.2, 11.2], 2.1, 0.75), 0.7);
  // Wings, folded along the sides. Their tips cross the tail.
  const q = [x, y * 0.966 + z * 0.259 + 1.6, z * 0.966 - y * 0.259];
  const wing = ellipsoid(q, [12.1, 1.2, -9.5], [4.6, 9.6, 20.5]);
  const tail = smoothMax(cone(p, [0, 10, -14], [0, 15, -33], 5.2, 5.6), Math.abs(px) - 5.4, 1);
  d = smoothMin(d, tail, 1.5);
  const angle = Math.atan2(x, -y);
  const breast = smoothstep(1.05, 0.85, angle) * smoothstep(8.5, 5, z) * smoothstep(-31, -28, z);
  const round = Math.atan2(px, -y) * 13.2;
  if (breast > 0 && Math.abs(d) < 4) d -= breast * 0.62 * feathers(round, z + 40, 5.2, 4.1, 4.6);
  const behind = smoothstep(1.9, 2.2, angle) * smoothstep(-20, -16, z) * smoothstep(27, 20, z);
  if (behind > 0 && Math.abs(d) < 4)
    d -= behind * 0.55 * feathers(Math.atan2(px, y) * 13.2, z + 40, 6, 5, 5.4);
  if (wing < 8) {
    // Small feathers above, long ones below.
    const upper = feathers(q[1] + 0.9, q[2] + 40, 4.6, 4.2, 4.8) * smoothstep(-11, -8.5, q[2]);
    const along = (q[1] - 1 + 0.12 * (q[2] + 20)) / 3.6,
      rib = 0.5 + 0.5 * Math.cos(2 * Math.PI * along);
    const long = rib * smoothstep(-8.2, -10.5, q[2]);
    d = smoothMin(d, wing - 0.6 * upper - 0.5 * long, 1.6);
  } else d = Math.min(d, wing - 1);
  if (y > 6 && z < -14) {
    const rib = 0.5 - 0.5 * Math.cos((2 * Math.PI * px) / 3.6);
    d += 0.5 * rib * smoothstep(-15, -19, z) * smoothstep(10, 13, y);
  }
  // Blend the foot into the plinth, because no tool reaches narrow slits. The toes grip the wood.
  d = smoothMin(d, plinth, 4.5);
  for (const aside of [-2.9, 0, 2.9])
    d = smoothMin(
      d,
      cone(
        p,
        [5.6 + 0.6 * aside, -10.5, -31.4],
        [5.6 + aside, -15.8 + 0.12 * aside * aside, -33],
        1.9,
        1.35,
      ),
      0.4,
    );
  return d;
}

async function figure() {
  const bench = await Bench.begin("figure", { stock: 1, wood: "limewood", long: 80, detail: 512 }),
    lap = timer(),
    shape = owlShape;
  const sides = [
      [0, -1, 0],
      [0, 1, 0],
      [-1, 0, 0],
      [1, 0, 0],
    ],
    diagonals = [
      [-1, -1, 0],
      [1, -1, 0],
      [-1, 1, 0],
      [1, 1, 0],
    ];
  // Begin from above, where the end of the log sets the plane for depth.
  await bench.look([0, 0, 1]);
  await bench.setPlane([0, 0, 40]);
  for (const [radius, apart, allowance, layer] of [
    [5, 3.6, 0.5, 4.5],
    [2, 1, 0, 3.6],
  ]) {
    await bench.choose({ radius });
    const room = { wide: 42 + radius, high: 42 + radius, from: 40.2, floor: -36, layer };
    await bench.carve(
      raster(bench, shape, {
        ...room,
        apart,
        along: 0.4,
        radius,
        allowance,
        tolerance: allowance > 0 ? 0.06 : 0.015,
      }),
    );
    lap(`from above with ${radius} mm`);
  }
  await bench.forces("figure-above");
  // Then the rest of the log at the foot, on every side.
  const face = async ([x, y, z]) => {
    await bench.look([x, y, z]);
    const angle = Math.atan2(y, x) + 0.04;
    await bench.setPlane([20 * Math.cos(angle), 20 * Math.sin(angle), -36.7]);
  };
  const all = { about: [0, 0, 3.5], wide: 44, high: 78, from: 21 };
  for (const [radius, apart, allowance, layer, views] of [
    [5, 3.6, 0.5, 4.5, sides],
    [2.5, 2, 0.25, 3.6, [...sides, ...diagonals]],
  ]) {
    await bench.choose({ radius });
    for (const view of views) {
      await face(view);
      const room = { ...all, floor: radius > 3 ? -1 : 2, layer };
      await bench.carve(
        raster(bench, shape, { ...room, apart, along: 0.7, radius, allowance, tolerance: 0.06 }),
      );
    }
    lap(`round it with ${radius} mm`);
  }
  await bench.forces("figure-round");
  await bench.choose({ radius: 1 });
  for (const view of [...sides, ...diagonals]) {
    await face(view);
    const room = { ...all, high: 74, about: [0, 0, 2.5], floor: 3 };
    await bench.carve(
      raster(bench, shape, { ...room, apart: 0.3, along: 0.28, radius: 1, tolerance: 0.012 }),
    );
    lap(`fine, from ${view}`);
  }
  const above = [...sides, ...diagonals].map(([x, y]) => [x, y, 1]);
  for (const view of above) {
    await face(view);
    const room = { about: [0, 0, 22], wide: 36, high: 42, from: 45, floor: 12 };
    await bench.carve(
      raster(bench, shape, { ...room, apart: 0.3, along: 0.28, radius: 1, tolerance: 0.012 }),
    );
    lap(`fine, from ${view}`);
  }
  // Around the foot, where larger balls had no room. Use layers, because a deep ball leaves
  // material in front of it.
  for (const view of [...sides, ...diagonals]) {
    await face(view);
    const room = { ...all, about: [0, 0, -31.4], high: 4.8, floor: 2, layer: 1.5 };
    await bench.carve(
      raster(bench, shape, { ...room, apart: 0.4, along: 0.3, radius: 1, tolerance: 0.012 }),
    );
  }
  lap("the foot");
  await bench.setView(["+", "ArrowDown", "ArrowDown"]);
  await bench.light(-0.42, 0.4);
  await bench.picture();
  const groove = Array.from({ length: 30 }, (_, i) => {
    const angle = ((-140 + 3.2 * i) * Math.PI) / 180;
    return [20 * Math.cos(angle), 20 * Math.sin(angle), -37];
  });
  await bench.pictureOfPage(groove, 0.6);
  const within = (place) =>
    Math.max(shape(place), Math.hypot(place[0], place[1]) - 20, Math.abs(place[2]) - 40);
  await bench.judge(volumeOf(within, [20, 20, 40], 0.25), within);
  await bench.end();
}

mkdirSync(out, { recursive: true });
const wanted = process.argv.slice(4),
  all = [bowl, relief, figure];
// carvers.mjs uses this bench too.
if (process.argv[1] === fileURLToPath(import.meta.url))
  await run(all.filter((piece) => wanted.length === 0 || wanted.includes(piece.name)));
