#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks the English of comments, docs (*.md, *.html), messages and identifiers:

- words that have a plainer standard term (WORDS), in comments, docs and string literals;
- sentences of more than 25 words, in comments and docs. Code blocks are skipped, and so are pictures in comments
  (indented lines, lines with columns);
- identifiers that contain a word of PARTS.

Prints file, line and sentence of each finding, and exits with 1 if there is one.
tools/english_allowed.txt lists exceptions.

Usage: check_english.py [FILE ...]
"""
import fnmatch
import io
import pathlib
import re
import subprocess
import sys
import tokenize

ROOT = pathlib.Path(__file__).resolve().parent.parent
ALLOWED = ROOT / "tools/english_allowed.txt"
MAX_WORDS = 25
WORDS = re.compile(r"\b(told|tells|mended|comes\s+to|is\s+felt|so\s+many|laid\s+bare|anew|owed|aslant|whoever)\b", re.I)
PARTS = {"most", "least", "told"}

SLASH = re.compile(r'(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<text>R"(?P<d>[^(\s]*)\(.*?\)(?P=d)"|"(?:\\.|[^"\\\n])*"'
                   r"|`(?:\\.|[^`\\])*`|(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])*')", re.S)
F_STRING = getattr(tokenize, "FSTRING_MIDDLE", tokenize.STRING)  # from Python 3.12 on
SOURCES = {".h", ".cpp", ".ts", ".mjs", ".js", ".py"}
# HTML: comments, scripts (no prose) and tags.
TAG = re.compile(r"<!--(?P<comment>.*?)-->|<(?:script|style)\b[^>]*>.*?</(?:script|style)>|<[^>]*>", re.S)
ATTRIBUTE = re.compile(r'\b(?:title|alt|placeholder|content|aria-label)="([^"]*)"')
MARKS = re.compile(r"^[ \t]*(///?<?|/\*\*?|\*/|\*|#!?)", re.M)  # of comments, at the start of a line
END = re.compile(r"(?<=[.!?:;])[)\"'*_`]*\s+|\n[ \t]*\n|\n(?=[ \t]*(?:[-*+•|]|\d+\.)[ \t])| · |\|")
PICTURE = re.compile(r"^(?:[ \t]{3,}\S|[^\n]*\S {2,}\S)[^\n]*$", re.M)  # lines of a picture in a comment
SKIPPED = {"apps/studio/messages.h", "web/src/connection/messages.ts",  # generated
           "tools/check_english.py"}


def line_of(text, at):
    return text.count("\n", 0, at) + 1


def sentences(text, first_line):
    """Yields (line, sentence) of a text. Colons, semicolons, list items and table cells end a sentence."""
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
    """Returns a page without its code blocks. The number of lines stays the same."""
    text = re.sub(r"^```.*?^```", lambda m: "\n" * m[0].count("\n"), text, flags=re.S | re.M)
    return re.sub(r"(?<=\n\n)(?: {4}[^\n]*\n+)+", lambda m: "\n" * m[0].count("\n"), text)


def prose_of_comment(comment):
    """Returns a comment without its marks and its indentation. The number of lines stays the same."""
    indent = re.match(r"[ \t]*", comment)[0]
    plain = MARKS.sub("", re.sub(f"^{indent}", "", comment, flags=re.M)) if indent else MARKS.sub("", comment)
    return PICTURE.sub("|", plain)  # ends a sentence


def prose_of_html(text):
    """Yields (line, text) of the comments, the texts and the titles of an HTML page."""
    at = 0
    for m in TAG.finditer(text):
        yield line_of(text, at), text[at:m.start()]
        if m["comment"]:
            yield line_of(text, m.start()), m["comment"]
        for said in ATTRIBUTE.finditer(m[0]):
            yield line_of(text, m.start() + said.start(1)), said[1]
        at = m.end()
    yield line_of(text, at), text[at:]


def pieces_of_slash(text):
    """Yields (start, end, is it a comment) of the comments and string literals of C++ and TypeScript."""
    for m in SLASH.finditer(text):
        yield m.start(), m.end(), bool(m["comment"])


def pieces_of_python(text):
    """The same for Python. A docstring counts as a comment."""
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    begun = True  # true at the start of a statement
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        start, end = (starts[line - 1] + column for line, column in (token.start, token.end))
        if token.type in {tokenize.COMMENT, tokenize.STRING, F_STRING}:
            docstring = token.type == tokenize.STRING and begun and token.string.endswith('"""')
            yield start, end, token.type == tokenize.COMMENT or docstring
        if token.type in {tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}:
            begun = True
        elif token.type not in {tokenize.COMMENT, tokenize.NL}:
            begun = False


def parts_of_code(text, pieces):
    """Lists (line, text) of comments and of string literals, and the code without both."""
    comments, strings, code, at, last = [], [], [], 0, (-1, -1)
    for start, end, is_comment in pieces(text):
        between, piece = text[at:start], text[start:end]
        code += [between, re.sub(r"[^\n]", " ", piece)]
        line, column = line_of(text, start), start - text.rfind("\n", 0, start)
        at = end
        if not is_comment:
            strings.append((line, piece))
            continue
        indented = text[start - column + 1:start] + piece  # prose_of_comment removes this indentation
        prose = prose_of_comment(piece if between.strip() or not piece.startswith('"') else indented)
        if not between.strip() and last == (line - 1, column):
            comments[-1][1] += "\n" + prose
        else:
            comments.append([line, prose])
        last = (line, column)  # a comment on the next line at this column continues this one
    return comments, strings, "".join([*code, text[at:]])


def findings(name, text):
    """Yields (line, kind of finding, sentence) of a file."""
    suffix = pathlib.Path(name).suffix
    if suffix == ".md":
        prose, strings, code = [(1, prose_of_page(text))], [], ""
    elif suffix == ".html":
        prose, strings, code = prose_of_html(text), [], ""
    else:
        prose, strings, code = parts_of_code(text, pieces_of_python if suffix == ".py" else pieces_of_slash)
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
    """Returns [glob, text, reason] for each line of ALLOWED."""
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
        if pathlib.Path(name).suffix not in {".md", ".html", *SOURCES} or name in SKIPPED:
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
