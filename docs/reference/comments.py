# SPDX-License-Identifier: MIT
"""Doxygen's input filter: prints a header with its plain comments as Doxygen's.

A block of `//` lines before a declaration describes it, and a `//` after a declaration describes that. The first block
describes the file.
"""
import re
import sys

lines = open(sys.argv[1], encoding="utf-8").read().split("\n")
first = True  # in the block that describes the file
for n, line in enumerate(lines):
    text = re.sub(r"[\\@<>#%]|&(?=\w+;)", lambda m: "\\" + m.group(), line) if line.lstrip().startswith("//") else line
    if line.startswith("// SPDX"):
        print("/// \\file")
        continue
    own = re.match(r"( *)//( .*)?$", text)
    if own:
        after = next((later for later in lines[n + 1:] if not later.lstrip().startswith("//")), "")
        describes = first or after.strip() not in ("", "}") and not after.strip().startswith(("#", "private:", "public:"))
        print(own[1] + ("///" if describes else "//") + (own[2] or ""))
        continue
    first = False
    trailing = re.match(r"(.*[;,{}]) +// (.*)$", line)
    if trailing and "namespace" not in trailing[1] and '"' not in line:
        comment = re.sub(r"[\\@<>#%]", lambda m: "\\" + m.group(), trailing[2])
        print(trailing[1] + (" ///< " + comment if not trailing[1].rstrip().endswith("{") else ""))
    else:
        print(line)
