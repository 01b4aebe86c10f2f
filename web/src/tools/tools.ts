// SPDX-License-Identifier: MIT
// The tools that a user can pick up. Each shape has a row with its texts, its options and how it is
// drawn. If the library has a shape without a row here, this file does not compile.
import { t } from "../base/texts";
import * as THREE from "three";
import { toCreasedNormals } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import type { Tool } from "../connection/kinds";
import type { Vec3 } from "../base/vec3";

/** Half-spaces exist only in scenes. */
export type HeldTool = Exclude<Tool, { shape: "halfspace" }>;
export type Shape = HeldTool["shape"];
type Of<S extends Shape> = Extract<HeldTool, { shape: S }>;

/** A number that the user sets in addition to the radius. A shape has at most one. */
interface Form {
  name: string;
  unit: string;
  min: number;
  max: number;
  value: number;
}
interface Row<S extends Shape> {
  name: string;
  /** The default key. */
  key: string;
  /** The content of an SVG of 24 by 24. */
  icon: string;
  /**
   * A motor turns the tool unless the user switches it off. A hand or a mallet drives other tools.
   */
  powered: boolean;
  /** A press drives the tool in, independent of the hand. */
  pressed?: boolean;
  form?: Form;
  /** True if the tool's rotation about its axis matters. */
  turns?: boolean;
  /** True if the tool turns its edge across or along its path. */
  leads?: boolean;
  make(radius: number, form: number): Of<S>;
  /** The distance from the tip to the other end [mm]. */
  height(tool: Of<S>): number;
  /** The tool, not higher than this if its shape can be shortened. */
  shortened(tool: Of<S>, height: number): Of<S>;
  /** The text that distinguishes it from others of its shape. */
  size(tool: Of<S>): string;
  /** Its surface. The tip is the origin, and the body extends along z. */
  surface(tool: Of<S>): THREE.BufferGeometry;
}

/** Distances from the tip to the other end [mm], if the tool's size does not determine them. */
const LENGTH = 25,
  FINGER_LENGTH = 20,
  BLADE = 1;
/** How far a blade leans back from upright [rad], and its drawn length [mm]. */
const LEAN = (50 * Math.PI) / 180,
  DRAWN = 45;
const SEGMENTS = 40;
/** Edges sharper than this angle are drawn sharp [rad]. */
const CREASE = 0.5;

const compact = (value: number): string => String(Number(value.toPrecision(3)));
const byRadius = (tool: { radius: number }): string => `${compact(tool.radius)} mm`;
const length = (tool: { length: number }): number => tool.length;
/** A surface of revolution from radii and heights above the tip. */
const lathe = (...points: [number, number][]): THREE.BufferGeometry =>
  toCreasedNormals(
    new THREE.LatheGeometry(
      points.map(([r, z]) => new THREE.Vector2(r, z)),
      SEGMENTS,
    ).rotateX(Math.PI / 2),
    CREASE,
  );
const ball = (radii: Vec3): THREE.BufferGeometry =>
  new THREE.SphereGeometry(1, SEGMENTS, 28)
    .rotateX(Math.PI / 2)
    .scale(...radii)
    .translate(0, 0, radii[2]);
/** A quarter circle of the profile, from its lowest point upwards. */
const arc = (r: number, z: number, radius: number, upTo = Math.PI / 2): [number, number][] =>
  Array.from({ length: 9 }, (_, i) => {
    const a = (i * upTo) / 8;
    return [r + radius * Math.sin(a), z - radius * Math.cos(a)];
  });
const half = (degrees: number): number => (degrees * Math.PI) / 360;
function pointed({
  angle_deg,
  radius,
  length,
}: {
  angle_deg: number;
  radius: number;
  length: number;
}): THREE.BufferGeometry {
  const slope = Math.tan(half(angle_deg)),
    wide = Math.min(radius, slope * length);
  return lathe([0, 0], [wide, wide / slope], [wide, length], [0, length]);
}

/**
 * A blade as it is drawn: it leans back from its edge, as a carver holds it. `outline` is the edge
 * seen along the path, from one side to the other [mm]. `wall` is the thickness of the steel above
 * it. The solid that cuts is upright; both have the same edge.
 */
function leaning(outline: [number, number][], wall: number): THREE.BufferGeometry {
  const inner = [...outline].reverse().map(([y, z]): [number, number] => {
    const middle = outline[Math.floor(outline.length / 2)];
    const widest = Math.max(...outline.map(([at]) => Math.abs(at - middle[0])));
    return [y - (wall * (y - middle[0])) / Math.max(widest, wall), z + wall];
  });
  const shape = new THREE.Shape([...outline, ...inner].map(([y, z]) => new THREE.Vector2(y, z)));
  const solid = new THREE.ExtrudeGeometry(shape, { depth: DRAWN, bevelEnabled: false });
  // Its x, y and depth become across, up and back along the blade.
  solid.applyMatrix4(
    new THREE.Matrix4().set(
      ...([0, 0, -Math.sin(LEAN), 0] as const),
      ...([1, 0, 0, 0] as const),
      ...([0, 1, Math.cos(LEAN), 0] as const),
      ...([0, 0, 0, 1] as const),
    ),
  );
  return toCreasedNormals(solid, CREASE);
}
/** As gouge_arc in kibori/solid/tools/gouge.h. */
function gougeArc(
  sweep: number,
  width: number,
): { across: number; upright: number; depth: number } {
  const radii = [2.5, 1.75, 1.25, 1, 0.75, 0.625, 0.55],
    depths = [0.5, 0.65, 0.85];
  if (sweep >= 9) {
    const depth = depths[sweep - 9] * width;
    return { across: width / 2, upright: depth, depth };
  }
  const r = radii[sweep - 2] * width;
  return { across: r, upright: r, depth: r - Math.sqrt(r * r - (width * width) / 4) };
}
/** The height of a skew chisel's bevels. The chisel cannot be shorter. */
function bevelsOf({ width, skew_deg, bevel_deg, thickness }: Of<"skew">): number {
  const skew = (skew_deg * Math.PI) / 180;
  return (
    1.001 * (width * Math.tan(skew) + thickness / 2 / Math.tan(half(bevel_deg)) / Math.cos(skew))
  );
}
const bladed = <T extends { length: number }>(tool: T, height: number): T => ({
  ...tool,
  length: Math.min(tool.length, height),
});
/** The tool with this height of head and neck, and without a shank. */
function withoutShank<T extends { reach: number; length: number }>(tool: T, height: number): T {
  const reach = Math.min(tool.reach, height);
  return { ...tool, reach, length: reach };
}
/** Head, neck and shank as a surface of revolution. */
const stemmed = (
  head: [number, number][],
  { neck, reach, shank, length }: { neck: number; reach: number; shank: number; length: number },
): THREE.BufferGeometry =>
  lathe(
    ...head,
    [neck, head[head.length - 1][1]],
    [neck, reach],
    [shank, reach],
    [shank, length],
    [0, length],
  );

/** The surface of the current stamp. */
let stamp = new THREE.BufferGeometry();
export function setStamp(vertices: Float32Array, triangles: Uint32Array): void {
  const solid = new THREE.BufferGeometry();
  solid.setAttribute("position", new THREE.BufferAttribute(vertices, 3));
  solid.setIndex(new THREE.BufferAttribute(triangles, 1));
  stamp.dispose();
  stamp = toCreasedNormals(solid, CREASE);
  stamp.computeBoundingBox();
}

export const TOOLS: { [S in Shape]: Row<S> } = {
  ball: {
    name: t("tool_ball"),
    key: "Shift+o",
    icon: '<circle cx="12" cy="12" r="9" />',
    powered: true,
    make: (radius) => ({ shape: "ball", radius }),
    height: (tool) => 2 * tool.radius,
    shortened: (tool) => tool,
    size: byRadius,
    surface: ({ radius }) => ball([radius, radius, radius]),
  },
  finger: {
    name: t("tool_finger"),
    key: "Shift+r",
    icon: '<path d="M4 3h16Q12 41 4 3z" />',
    powered: false,
    // As wide as a ball of this radius, at one radius above its tip.
    make: (radius) => ({ shape: "finger", ks: 1 / radius, length: FINGER_LENGTH }),
    height: length,
    shortened: (tool, height) => ({ ...tool, length: Math.min(tool.length, height) }),
    size: (tool) => `Ks ${compact(tool.ks)}/mm`,
    surface({ ks, length }) {
      const heights = Array.from({ length: 25 }, (_, i) => (length * i * i) / (24 * 24));
      return lathe(...heights.map((z): [number, number] => [Math.sqrt(z / ks), z]));
    },
  },
  flat: {
    name: t("tool_flat"),
    key: "Shift+e",
    icon: '<path d="M6 2h12v19H6z" />',
    powered: true,
    make: (radius) => ({ shape: "flat", radius, length: LENGTH }),
    height: length,
    shortened: (tool, height) => ({ ...tool, length: Math.min(tool.length, height) }),
    size: byRadius,
    surface: ({ radius, length }) => lathe([0, 0], [radius, 0], [radius, length], [0, length]),
  },
  bull: {
    name: t("tool_bull"),
    key: "Shift+u",
    icon: '<path d="M6 2h12v14a5 5 0 0 1-5 5h-2a5 5 0 0 1-5-5z" />',
    powered: true,
    form: { name: t("form_corner"), unit: "mm", min: 0.1, max: 12, value: 1.5 },
    make: (radius, corner) => ({
      shape: "bull",
      radius,
      corner: Math.min(corner, radius),
      length: LENGTH,
    }),
    height: length,
    shortened: (tool, height) => ({
      ...tool,
      length: Math.min(tool.length, Math.max(height, 2 * tool.corner)),
    }),
    size: byRadius,
    surface: ({ radius, corner, length }) =>
      lathe([0, 0], ...arc(radius - corner, corner, corner), [radius, length], [0, length]),
  },
  cone: {
    name: t("tool_cone"),
    key: "Shift+i",
    icon: '<path d="M6 2h12v8l-6 11-6-11z" />',
    powered: true,
    form: { name: t("form_angle"), unit: "°", min: 20, max: 150, value: 90 },
    make: (radius, angle_deg) => ({ shape: "cone", angle_deg, radius, length: LENGTH }),
    height: length,
    shortened: (tool, height) => ({ ...tool, length: Math.min(tool.length, height) }),
    size: byRadius,
    surface: pointed,
  },
  tapered: {
    name: t("tool_tapered"),
    key: "Shift+a",
    icon: '<path d="M7 2h10v6l-2.8 12a2.3 2.3 0 0 1-4.4 0L7 8zM7 8h10" />',
    powered: true,
    form: { name: t("form_taper"), unit: "°", min: 5, max: 120, value: 20 },
    // The ball has a third of the shank's radius, as on common cutters.
    make: (radius, angle_deg) => ({
      shape: "tapered",
      ball: radius / 3,
      angle_deg,
      radius,
      length: LENGTH,
    }),
    height: length,
    shortened: (tool, height) => ({
      ...tool,
      length: Math.min(tool.length, Math.max(height, 2 * tool.ball)),
    }),
    size: (tool) => `${compact(tool.radius)} mm, ball ${compact(tool.ball)} mm`,
    surface({ ball, angle_deg, radius, length }) {
      const a = half(angle_deg),
        apex = ball - ball / Math.sin(a),
        full = Math.min(length, apex + radius / Math.tan(a));
      const wide = Math.min(radius, (full - apex) * Math.tan(a));
      return lathe(
        ...arc(0, ball, ball, Math.PI / 2 - a),
        [wide, full],
        [wide, length],
        [0, length],
      );
    },
  },
  capsule: {
    name: t("tool_capsule"),
    key: "Shift+y",
    icon: '<rect x="7" y="2" width="10" height="20" rx="5" />',
    powered: false,
    make: (radius) => ({ shape: "capsule", radius, length: LENGTH + 2 * radius }),
    height: length,
    shortened: (tool, height) => ({
      ...tool,
      length: Math.min(tool.length, Math.max(height, 2 * tool.radius)),
    }),
    size: byRadius,
    surface: ({ radius, length }) =>
      new THREE.CapsuleGeometry(radius, length - 2 * radius, 12, SEGMENTS)
        .rotateX(Math.PI / 2)
        .translate(0, 0, length / 2),
  },
  box: {
    name: t("tool_box"),
    key: "Shift+x",
    icon: '<path d="M4 7l6-4h10v13l-6 5H4zM4 7h10v14M14 7l6-4" />',
    powered: false,
    turns: true,
    form: { name: t("form_breadth"), unit: "mm", min: 0.5, max: 24, value: 4 },
    make: (radius, breadth) => ({ shape: "box", size: [2 * radius, breadth, LENGTH] }),
    height: (tool) => tool.size[2],
    shortened: ({ size }, height) => ({
      shape: "box",
      size: [size[0], size[1], Math.min(size[2], height)],
    }),
    size: (tool) => `${compact(tool.size[0])} mm`,
    surface: ({ size }) => new THREE.BoxGeometry(...size).translate(0, 0, size[2] / 2),
  },
  ellipsoid: {
    name: t("tool_ellipsoid"),
    key: "Shift+z",
    icon: '<ellipse cx="12" cy="12" rx="10" ry="6.5" />',
    powered: false,
    turns: true,
    form: { name: t("form_breadth"), unit: "mm", min: 1, max: 24, value: 12 },
    make: (radius, breadth) => ({ shape: "ellipsoid", radii: [radius, breadth / 2, radius] }),
    height: (tool) => 2 * tool.radii[2],
    shortened: (tool) => tool,
    size: (tool) => `${compact(tool.radii[0])} mm`,
    surface: ({ radii }) => ball(radii),
  },
  drill: {
    name: t("tool_drill"),
    key: "Shift+d",
    icon: '<path d="M8 2h8v17l-4 3-4-3zM8 9l8-4M8 14l8-4M8 19l8-4" />',
    powered: true,
    form: { name: t("form_point"), unit: "°", min: 60, max: 150, value: 118 },
    make: (radius, angle_deg) => ({ shape: "drill", angle_deg, radius, length: LENGTH }),
    height: length,
    shortened: (tool, height) => ({ ...tool, length: Math.min(tool.length, height) }),
    size: byRadius,
    surface: pointed,
  },
  gouge: {
    name: t("tool_gouge"),
    key: "Shift+g",
    icon: '<path d="M3 7c0 18 18 18 18 0M6.5 7c0 12 11 12 11 0M3 7h3.5M17.5 7H21" />',
    powered: false,
    turns: true,
    leads: true,
    form: { name: t("form_sweep"), unit: "", min: 2, max: 11, value: 7 },
    make: (radius, sweep) => ({
      shape: "gouge",
      sweep: Math.round(sweep),
      width: 2 * radius,
      thickness: BLADE,
      length: LENGTH,
    }),
    height: length,
    shortened: bladed,
    size: (tool) => `no. ${tool.sweep}, ${compact(tool.width)} mm`,
    surface({ sweep, width }) {
      const { across, upright, depth } = gougeArc(sweep, width);
      const wall = Math.min(1.5, width / 8),
        sides: [number, number][] = sweep > 9 ? [[width / 2, depth + width / 8]] : [];
      const round = Array.from({ length: 25 }, (_, i): [number, number] => {
        const y = (width / 2) * Math.sin((Math.PI * (i - 12)) / 24);
        return [y, upright * (1 - Math.sqrt(Math.max(0, 1 - (y / across) ** 2)))];
      });
      return leaning(
        [...sides.map(([y, z]): [number, number] => [-y, z]), ...round, ...sides],
        wall,
      );
    },
  },
  vee: {
    name: t("tool_vee"),
    key: "Shift+v",
    icon: '<path d="M3 5l9 16 9-16M7 5l5 9 5-9M3 5h4M17 5h4" />',
    powered: false,
    turns: true,
    leads: true,
    form: { name: t("form_angle"), unit: "°", min: 20, max: 150, value: 60 },
    make: (radius, angle_deg) => ({
      shape: "vee",
      angle_deg,
      width: 2 * radius,
      thickness: BLADE,
      length: LENGTH,
    }),
    height: length,
    shortened: bladed,
    size: (tool) => `${compact(tool.angle_deg)}°, ${compact(tool.width)} mm`,
    surface({ angle_deg, width }) {
      const high = width / 2 / Math.tan(half(angle_deg));
      return leaning(
        [
          [-width / 2, high],
          [0, 0],
          [width / 2, high],
        ],
        Math.min(1.5, width / 8),
      );
    },
  },
  chisel: {
    name: t("tool_chisel"),
    key: "Shift+c",
    icon: '<path d="M7 2h10v14H7zM7 16v5h10v-5" />',
    powered: false,
    turns: true,
    leads: true,
    form: { name: t("form_bevel"), unit: "°", min: 10, max: 60, value: 25 },
    make: (radius, bevel_deg) => ({
      shape: "chisel",
      width: 2 * radius,
      bevel_deg,
      thickness: 2 * BLADE,
      length: LENGTH,
    }),
    height: length,
    shortened: bladed,
    size: (tool) => `${compact(tool.width)} mm`,
    surface: ({ width, thickness }) =>
      leaning(
        [
          [-width / 2, 0],
          [0, 0],
          [width / 2, 0],
        ],
        thickness,
      ),
  },
  skew: {
    name: t("tool_skew"),
    key: "Shift+s",
    icon: '<path d="M7 2h10v14L7 21z" />',
    powered: false,
    turns: true,
    leads: true,
    form: { name: t("form_skew"), unit: "°", min: 5, max: 60, value: 30 },
    make(radius, skew_deg) {
      const tool: Of<"skew"> = {
        shape: "skew",
        width: 2 * radius,
        skew_deg,
        bevel_deg: 25,
        thickness: 2 * BLADE,
        length: LENGTH,
      };
      return { ...tool, length: Math.max(LENGTH, bevelsOf(tool)) };
    },
    height: length,
    shortened: (tool, height) => ({
      ...tool,
      length: Math.min(tool.length, Math.max(height, bevelsOf(tool))),
    }),
    size: (tool) => `${compact(tool.width)} mm`,
    surface: ({ width, skew_deg, thickness }) =>
      leaning(
        [
          [0, 0],
          [width / 2, (width / 2) * Math.tan((skew_deg * Math.PI) / 180)],
          [width, width * Math.tan((skew_deg * Math.PI) / 180)],
        ],
        thickness,
      ),
  },
  knife: {
    name: t("tool_knife"),
    key: "Shift+n",
    icon: '<path d="M12 22L7 12V2h10v10zM12 22V2" />',
    powered: false,
    turns: true,
    leads: true,
    form: { name: t("form_point"), unit: "°", min: 20, max: 120, value: 60 },
    make: (radius, point_deg) => ({
      shape: "knife",
      edge_deg: 20,
      point_deg,
      length: 3 * radius + 3,
    }),
    height: length,
    shortened: (tool, height) => ({ ...tool, length: Math.min(tool.length, height) }),
    size: (tool) => `${compact(tool.length)} mm`,
    surface({ edge_deg, point_deg, length }) {
      const wide = length * Math.tan(half(point_deg)),
        thick = length * Math.sin(half(point_deg)) * Math.tan(half(edge_deg));
      return toCreasedNormals(
        new THREE.ConeGeometry(1, length, 4)
          .rotateX(-Math.PI / 2)
          .translate(0, 0, length / 2)
          .scale(wide, thick, 1),
        0.1,
      );
    },
  },
  lollipop: {
    name: t("tool_lollipop"),
    key: "Shift+j",
    icon: '<path d="M10 2h4v9h-4z" /><circle cx="12" cy="16.5" r="5.5" />',
    powered: true,
    form: { name: t("form_neck"), unit: "mm", min: 0.3, max: 10, value: 1.5 },
    make(radius, wide) {
      const neck = Math.min(wide, 0.9 * radius),
        reach = 2 * radius + LENGTH;
      return {
        shape: "lollipop",
        radius,
        neck,
        reach,
        shank: Math.max(neck, 3),
        length: reach + 15,
      };
    },
    height: length,
    shortened: (tool, height) => withoutShank(tool, Math.max(height, 2 * tool.radius)),
    size: byRadius,
    surface: (tool) =>
      stemmed(arc(0, tool.radius, tool.radius, Math.PI - Math.asin(tool.neck / tool.radius)), tool),
  },
  tslot: {
    name: t("tool_tslot"),
    key: "Shift+h",
    icon: '<path d="M10 2h4v12h7v6H3v-6h7z" />',
    powered: true,
    form: { name: t("form_height"), unit: "mm", min: 0.3, max: 12, value: 2 },
    make(radius, height) {
      const neck = 0.4 * radius,
        reach = height + LENGTH;
      return {
        shape: "tslot",
        radius,
        height,
        neck,
        reach,
        shank: Math.max(neck, 3),
        length: reach + 15,
      };
    },
    height: length,
    shortened: (tool, height) => withoutShank(tool, Math.max(height, tool.height)),
    size: byRadius,
    surface: (tool) =>
      stemmed(
        [
          [0, 0],
          [tool.radius, 0],
          [tool.radius, tool.height],
        ],
        tool,
      ),
  },
  mesh: {
    name: t("tool_mesh"),
    key: "Shift+w",
    icon: '<path d="M9 2h6v6l-2 3v3h7v4H4v-4h7v-3L9 8zM5 21h14" />',
    powered: true,
    pressed: true,
    turns: true,
    leads: true,
    make: () => ({ shape: "mesh" }),
    height: () => stamp.boundingBox?.max.z ?? 0,
    shortened: (tool) => tool,
    size: () => "",
    surface: () => stamp.clone(),
  },
};
export const SHAPES = Object.keys(TOOLS) as Shape[];
/** One tool of every shape, for tests. `share` sets the number of its Form: 0 is min, 1 is max. */
export const everyTool = (radius: number, share: number): HeldTool[] =>
  SHAPES.map((shape) => {
    const { form, make } = TOOLS[shape];
    return make(radius, form ? form.min + share * (form.max - form.min) : 0);
  });

/** The shape of this name. Null: there is none. */
export const shapeOf = (name: string): Shape | null => (name in TOOLS ? (name as Shape) : null);
/** The tool if a user can hold it. Null for tools that exist only in scenes. */
export const held = (tool: Tool | null): HeldTool | null =>
  tool && tool.shape in TOOLS ? (tool as HeldTool) : null;

// A row's functions take tools of its own shape, so look the row up by that shape.
const rowOf = (tool: HeldTool): Row<Shape> => TOOLS[tool.shape] as unknown as Row<Shape>;
export const heightOf = (tool: HeldTool): number => rowOf(tool).height(tool);
export const shortened = (tool: HeldTool, height: number): HeldTool =>
  rowOf(tool).shortened(tool, height);
export const sizeOf = (tool: HeldTool): string => rowOf(tool).size(tool);
export const toolSurface = (tool: HeldTool): THREE.BufferGeometry => rowOf(tool).surface(tool);

/** A picture of the shape. */
export const iconOf = (shape: Shape): string =>
  `<svg viewBox="0 0 24 24" aria-hidden="true">${TOOLS[shape].icon}</svg>`;
/** One button per shape. The first is chosen. */
export const toolButtons = (): string =>
  SHAPES.map((shape, i) => {
    const { name, key } = TOOLS[shape];
    const button = `<input type="radio" name="shape" value="${shape}" aria-label="${name}"${i === 0 ? " checked" : ""} />`;
    return `<label title="${t("tool_key", { tool: name, key })}">${button}${iconOf(shape)}<span aria-hidden="true">${name}</span></label>`;
  }).join("");
