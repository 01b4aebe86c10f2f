// SPDX-License-Identifier: MIT
// Presets as TOML. The reader accepts the part of TOML that the writer uses: [[preset]], and
// key = value with numbers, true, false and basic strings.
//
//     [[preset]]
//     name = "Fine V"
//     tool = "vee"
//     size = 1.2

export interface Preset {
  name: string;
  /** A shape, or "brush:" and a mode. */
  item: string;
  /** The numbers and choices by the ids of their controls, as in tool_memory.ts. */
  values: Record<string, string>;
}

export class PresetError extends Error {
  constructor(
    /** From 1. */
    readonly line: number,
    readonly reason: "line" | "value" | "tool" | "name",
  ) {
    super(reason);
  }
}

const BRUSH = "brush:";
const KEY = /^[a-z][a-z-]*$/;
/** Max lengths, so that a foreign file cannot fill the browser's storage. */
const MAX_TEXT = 100,
  MAX_LINES = 10000;

const isNumber = (text: string): boolean => Number.isFinite(Number(text));
/** A choice from a list, such as a texture. */
const CHOICE = /^[a-z_]+$/;

export const toToml = (presets: Preset[]): string =>
  presets
    .map(({ name, item, values }) => {
      const [kind, value] = item.startsWith(BRUSH)
        ? ["brush", item.slice(BRUSH.length)]
        : ["tool", item];
      const lines = Object.entries(values).map(
        ([key, text]) => `${key} = ${isNumber(text) ? text : JSON.stringify(text)}`,
      );
      return ["[[preset]]", `name = ${JSON.stringify(name)}`, `${kind} = "${value}"`, ...lines]
        .join("\n")
        .concat("\n");
    })
    .join("\n");

/** The value as text, whether it is a number or a text. */
function valueOf(text: string, line: number): string {
  const string = /^("(?:\\.|[^"\\])*")\s*(#.*)?$/.exec(text);
  if (string) {
    try {
      return (JSON.parse(string[1]) as string).slice(0, MAX_TEXT);
    } catch {
      throw new PresetError(line, "value");
    }
  }
  const plain = text.replace(/\s*#.*$/, "");
  if (plain === "true") return "1";
  if (plain === "false") return "0";
  if (!/^[+-]?\d+(\.\d+)?([eE][+-]?\d+)?$/.test(plain)) throw new PresetError(line, "value");
  return String(Number(plain));
}

/** Reads presets. `known` returns whether a tool or brush exists. Throws a PresetError. */
export function fromToml(text: string, known: (item: string) => boolean): Preset[] {
  const presets: { preset: Preset; line: number }[] = [];
  text
    .split(/\r?\n/)
    .slice(0, MAX_LINES)
    .forEach((row, i) => {
      const line = i + 1,
        plain = row.trim();
      if (plain === "" || plain.startsWith("#")) return;
      if (/^\[\[\s*preset\s*\]\]\s*(#.*)?$/.test(plain)) {
        presets.push({ preset: { name: "", item: "", values: {} }, line });
        return;
      }
      const [, key, value] = /^([^=\s]+)\s*=\s*(.+)$/.exec(plain) ?? [];
      const last = presets.at(-1)?.preset;
      if (!last || !key || !KEY.test(key)) throw new PresetError(line, "line");
      const read = valueOf(value, line);
      if (key === "name") last.name = read;
      else if (key === "tool" || key === "brush") {
        last.item = key === "brush" ? BRUSH + read : read;
        if (!known(last.item)) throw new PresetError(line, "tool");
      } else if (isNumber(read) || CHOICE.test(read)) last.values[key] = read;
      else throw new PresetError(line, "value");
    });
  for (const { preset, line } of presets) {
    if (preset.name.trim() === "") throw new PresetError(line, "name");
    if (preset.item === "") throw new PresetError(line, "tool");
  }
  return presets.map(({ preset }) => preset);
}
