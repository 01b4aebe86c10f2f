#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the English of comments, docs (*.md), messages and identifiers:

- words that have a plainer standard term (WORDS), in comments, docs and string literals;
- sentences of more than 25 words, in comments and docs. Code blocks and the pictures of comments
  (indented lines, lines with columns) do not count;
- identifiers with a part of PARTS.

Prints file, line and sentence of each finding, and exits with 1 if there is one.
tools/english_allowed.txt lists exceptions.

Usage: check_english.py [FILE ...]
"""
import fnmatch
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
ALLOWED = ROOT / "tools/english_allowed.txt"
MAX_WORDS = 25
WORDS = re.compile(r"\b(told|tells|mended|comes\s+to|is\s+felt|so\s+many|laid\s+bare|anew|owed|aslant|whoever)\b", re.I)
PARTS = {"most", "least", "told"}

SLASH = re.compile(r'(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<text>R"(?P<d>[^(\s]*)\(.*?\)(?P=d)"|"(?:\\.|[^"\\\n])*"'
                   r"|`(?:\\.|[^`\\])*`|(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])*')", re.S)
HASH = re.compile(r'(?P<comment>\#[^\n]*|(?<=\n)[ \t]*"""(?:\\.|[^\\])*?""")'
                  r'|(?P<text>("""|\'\'\')(?:\\.|[^\\])*?\3|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\')', re.S)
SYNTAX = {".h": SLASH, ".cpp": SLASH, ".ts": SLASH, ".mjs": SLASH, ".js": SLASH, ".py": HASH}
MARKS = re.compile(r"^[ \t]*(///?<?|/\*\*?|\*/|\*|#!?)", re.M)  # of comments, at the start of a line
END = re.compile(r"(?<=[.!?:;])[)\"'*_`]*\s+|\n[ \t]*\n|\n(?=[ \t]*(?:[-*+•|]|\d+\.)[ \t])| · |\|")
PICTURE = re.compile(r"^(?:[ \t]{3,}\S|[^\n]*\S {2,}\S)[^\n]*$", re.M)  # lines of a comment
SKIPPED = {"apps/studio/messages.h", "web/src/connection/messages.ts",  # generated
           "tools/check_english.py"}


def line_of(text, at):
    return text.count("\n", 0, at) + 1


def sentences(text, first_line):
    """(line, sentence) of a text. Colons, semicolons, list items and table cells end a sentence."""
    start = 0
    for end in [*(m.start() for m in END.finditer(text)), len(text)]:
        part = text[start:end].lstrip(" \t\n|*-)\"'_")
        if part:
            yield first_line + line_of(text, end - len(part)) - 1, " ".join(part.split())
        start = end


def word_count(sentence):
    plain = re.sub(r"`[^`]*`|\]\([^)]*\)|https?://\S+|\$[^$]*\$", " x ", sentence)
    return len(re.findall(r"[^\W_][\w.'’/-]*", plain))


def prose_of_page(text):
    """A page without code blocks, with the same lines."""
    text = re.sub(r"^```.*?^```", lambda m: "\n" * m[0].count("\n"), text, flags=re.S | re.M)
    return re.sub(r"(?<=\n\n)(?: {4}[^\n]*\n+)+", lambda m: "\n" * m[0].count("\n"), text)


def prose_of_comment(comment):
    """A comment without its marks and its indentation, with the same lines."""
    indent = re.match(r"[ \t]*", comment)[0]
    plain = MARKS.sub("", re.sub(f"^{indent}", "", comment, flags=re.M)) if indent else MARKS.sub("", comment)
    return PICTURE.sub("|", plain)  # ends a sentence


def parts_of_code(text, syntax):
    """Lists (line, text) of comments and of string literals, and the code without both."""
    comments, strings, code, at, last = [], [], [], 0, (-1, -1)
    for m in syntax.finditer(text):
        between = text[at:m.start()]
        code += [between, re.sub(r"[^\n]", " ", m[0])]
        line, column = line_of(text, m.start()), m.start() - text.rfind("\n", 0, m.start())
        if m["text"]:
            strings.append((line, m[0]))
        elif not between.strip() and last == (line - 1, column):
            comments[-1][1] += "\n" + prose_of_comment(m[0])
        else:
            comments.append([line, prose_of_comment(m[0])])
        at = m.end()
        if m["comment"]:
            last = (line, column)  # a comment of the next line that begins there continues it
    return comments, strings, "".join([*code, text[at:]])


def findings(name, text):
    """(line, what, sentence) of a file."""
    suffix = pathlib.Path(name).suffix
    if suffix == ".md":
        prose, strings, code = [(1, prose_of_page(text))], [], ""
    else:
        prose, strings, code = parts_of_code(text, SYNTAX[suffix])
    for line, part in prose:
        for at, sentence in sentences(part, line):
            if (count := word_count(sentence)) > MAX_WORDS:
                yield at, f"{count} words", sentence
            if found := WORDS.search(re.sub(r"`[^`]*`", "x", sentence)):
                yield at, f"'{found[0]}'", sentence
    for line, part in strings:
        part = re.sub(r"\$\{[^{}]*\}", lambda m: "\n" * m[0].count("\n"), part)
        if (found := WORDS.search(part)) and " " in part:  # a word alone is a key or a name
            yield line + part.count("\n", 0, found.start()), f"'{found[0]}'", " ".join(part.split())[:120]
    seen = set()
    for m in re.finditer(r"[A-Za-z_]\w*", code):
        parts = {p.lower() for p in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", m[0])}
        if parts & PARTS and m[0] not in seen:
            seen.add(m[0])
            yield line_of(code, m.start()), "identifier", m[0]


def read_allowed():
    """[glob, text, reason] of each line."""
    lines = ALLOWED.read_text(encoding="utf-8").splitlines()
    return [[field.strip() for field in line.split("|")] for line in lines if line and line[0] != "#"]


def main():
    names = sys.argv[1:]
    if not names:
        listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
        names = listed.stdout.splitlines()
    allowed, used, bad = read_allowed(), set(), 0
    for entry in allowed:
        if len(entry) != 3 or not all(entry):
            sys.exit(f"{ALLOWED.name}: a line is 'files | text | reason', not '{' | '.join(entry)}'")
    for name in names:
        if pathlib.Path(name).suffix not in {".md", *SYNTAX} or name in SKIPPED:
            continue
        for line, what, sentence in findings(name, (ROOT / name).read_text(encoding="utf-8")):
            fits = [i for i, (files, part, _) in enumerate(allowed) if fnmatch.fnmatch(name, files) and part in sentence]
            used.update(fits)
            if not fits:
                bad += 1
                print(f"{name}:{line}: {what}: {sentence}")
    if not sys.argv[1:]:
        for i, (files, text, _) in enumerate(allowed):
            if i not in used:
                bad += 1
                print(f"{ALLOWED.name}: nothing matches '{files} | {text}' any more; remove the line")
    if bad:
        print(f"{bad} findings. Use shorter sentences and the standard term (CONTRIBUTING.md, How we write).")
    sys.exit(bad > 0)


if __name__ == "__main__":
    main()
