#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the studio's messages for C++, TypeScript and people from protocol/messages.json. With
--check it writes nothing, and exits with 1 if a file is out of date."""
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
CPP = {"u8": "uint8_t", "u16": "uint16_t", "u32": "uint32_t", "f64": "double", "vec3": "Vec3", "text": "std::string",
       "bytes": "std::vector<uint8_t>", "mode": "Mode", "model": "ForceModel", "tool": "std::string"}
ZERO = {"u8": " = 0", "u16": " = 0", "u32": " = 0", "f64": " = 0", "vec3": " = Vec3::Zero()", "text": "", "bytes": "", "mode": " = Mode::cut",
        "model": " = ForceModel::series", "tool": ""}
TS = {"u8": "number", "u16": "number", "u32": "number", "f64": "number", "vec3": "Vec3", "text": "string", "bytes": "Uint8Array",
      "mode": "Mode", "model": "Model", "tool": "Tool | null"}
CALL = {"bytes": "raw"}  # the bytes methods of Writer and Reader have this name
MADE = "Made by tools/make_protocol.py from protocol/messages.json; edit that file."


def cpp(table):
    out = [f"// SPDX-License-Identifier: MIT\n// {MADE}", "#pragma once\n",
           "#include <cstdint>\n#include <string>\n#include <variant>\n#include <vector>\n",
           "#include <kibori/motion/tool_tick.h>\n",
           '#include "apps/studio/wire.h"\n', "namespace kibori::studio {\n",
           f"inline constexpr uint16_t kProtocolVersion = {table['version']};\n"]
    for m in table["messages"]:
        out.append(f"// {m['about']}" if len(m["about"]) < 105 else "\n".join(wrap(m["about"])))
        out.append(f"struct {m['name']} {{\n  static constexpr uint8_t kKind = {m['kind']};")
        out += [f"  {CPP[kind]} {name}{ZERO[kind]};" for name, kind, *_ in m["fields"]]
        names = ", ".join(name for name, *_ in m["fields"])
        ranges = [in_range(*field) for field in m["fields"] if len(field) == 3]
        if ranges:
            out.append("  bool in_range() const {\n    return " + " &&\n           ".join(ranges) + ";\n  }")
        out.append("  template <class F>\n  void fields([[maybe_unused]] F&& f) {" + (f"\n    f({names});\n  " if names else "") + "}")
        out.append("};")
    pages = [m["name"] for m in table["messages"] if m["from"] == "page"]
    out.append("\n// The messages that a page may send.\nusing FromPage = std::variant<" + ", ".join(pages) + ">;\n")
    out.append("}  // namespace kibori::studio\n")
    return "\n".join(out)


def in_range(name, kind, between):
    low, high = (f"{end:g}" if kind in ("f64", "vec3") else str(end) for end in between)
    if kind == "vec3":
        return f"{name}.minCoeff() >= {low} && {name}.maxCoeff() <= {high}"
    if kind in ("text", "bytes", "tool"):
        name = f"{name}.size()"
    # Do not compare an unsigned number with 0.
    return f"{name} <= {high}" if low == "0" and kind != "f64" else f"{name} >= {low} && {name} <= {high}"


def declaration(name, kind, *between):
    return f"{name} {kind}" + (f" {between[0][0]:g}…{between[0][1]:g}" if between else "")


def wrap(text):
    lines, line = [], "//"
    for word in text.split():
        if len(line) + 1 + len(word) > 100:
            lines.append(line)
            line = "//"
        line += " " + word
    return lines + [line]


def ts(table):
    out = [f"// SPDX-License-Identifier: MIT\n// {MADE}", 'import type { Vec3 } from "../base/vec3";\nimport type { Mode, Model, Tool } from "./kinds";\nimport { Reader, Writer } from "./wire";\n',
           f"export const PROTOCOL_VERSION = {table['version']};\n"]
    for m in table["messages"]:
        fields = "; ".join(f"{name}: {TS[kind]}" for name, kind, *_ in m["fields"])
        out.append(f"/** {m['about']} */\nexport interface {m['name']} {{ {fields} }}" if fields else
                   f"/** {m['about']} */\nexport type {m['name']} = Record<string, never>;")
    out.append("\nexport const write = {")
    for m in table["messages"]:
        if m["from"] == "page":
            puts = "".join(f".{CALL.get(kind, kind)}(m.{name})" for name, kind, *_ in m["fields"])
            arg = f"m: {m['name']}" if m["fields"] else ""
            out.append(f"  {m['name']}: ({arg}) => new Writer({m['kind']}){puts}.done(),")
    out.append("};\n\n/** The messages that the studio may send. */\nexport type FromStudio =")
    out += [f"  | {{ kind: \"{m['name']}\"; message: {m['name']} }}" for m in table["messages"] if m["from"] == "studio"]
    out[-1] += ";"
    out.append("\n/** Throws if the data is not one of these messages, or has the wrong length. */\nexport function read(data: ArrayBuffer): FromStudio {\n  const r = new Reader(data);\n  const kind = r.u8();\n  switch (kind) {")
    for m in table["messages"]:
        if m["from"] == "studio":
            gets = ", ".join(f"{name}: r.{CALL.get(kind, kind)}()" for name, kind, *_ in m["fields"])
            out.append(f"    case {m['kind']}:\n      return r.end({{ kind: \"{m['name']}\", message: {{ {gets} }} }});")
    out.append("    default:\n      throw new Error(`unknown kind ${kind} of message`);\n  }\n}\n")
    return "\n".join(out)


def people(table):
    out = ["# The studio's protocol\n", f"{MADE}\n", f"Version {table['version']}. {table['about']}\n",
           "| kind | name | from | fields | |", "|---|---|---|---|---|"]
    for m in table["messages"]:
        fields = ", ".join(declaration(*field) for field in m["fields"])
        out.append(f"| {m['kind']} | `{m['name']}` | {m['from']} | {fields} | {m['about']} |")
    return "\n".join(out) + "\n"


def main():
    table = json.loads((ROOT / "protocol/messages.json").read_text())
    wrong = 0
    for path, text in {"apps/studio/messages.h": cpp(table), "web/src/connection/messages.ts": ts(table),
                       "docs/protocol.md": people(table)}.items():
        file = ROOT / path
        if file.exists() and file.read_text() == text:
            continue
        if "--check" in sys.argv:
            print(f"{path} is not what protocol/messages.json says; run tools/make_protocol.py")
            wrong = 1
        else:
            file.write_text(text)
    return wrong


sys.exit(main())
