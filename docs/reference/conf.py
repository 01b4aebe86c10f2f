# SPDX-License-Identifier: MIT
"""The reference of `import kibori`, from its docstrings: ./dev reference."""
import re

import kibori

project = "Kibori"
author = copyright = "the Kibori authors"
version = release = kibori.__version__
extensions = ["sphinx.ext.autodoc"]
html_theme = "alabaster"
html_theme_options = {"description": "carve virtual solids by hand and feel them", "page_width": "1100px", "sidebar_width": "200px"}
html_sidebars = {"**": ["about.html", "localtoc.html", "searchbox.html"]}
html_show_sourcelink = False
html_copy_source = False
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
MADE = re.compile(r"\w+(\(.*?\)): ")
# What pybind11 says in full, as the stubs say it (python/kibori/__init__.pyi).
SHORTER = [(r"Union\[(kibori\._kibori\.\w+, )*kibori\._kibori\.Finger[^\]]*\]", "Shape"), (r"kibori\._kibori\.", ""), (r"\bself: \w+(, )?", ""),
           (r"numpy\.ndarray\[numpy\.(\w+)[^\]]*\]", r"array of \1"), (r"(List|list)\[float\[(\d)\]\]", r"\2 numbers"), (r"os\.PathLike", "path"),
           (r"\*, \)", ")")]


def shorter(text):
    for long, short in SHORTER:
        text = re.sub(long, short, text or "")
    return text


def signature(app, what, name, obj, options, signature, return_annotation):
    # A class says how it is made in the first line of its own docstring.
    if what == "class":
        made = MADE.match(obj.__doc__ or "")
        return (made[1] if made else ""), None
    return (shorter(signature), shorter(return_annotation)) if signature else None


def lines_of(app, what, name, obj, options, lines):
    """Paragraphs as they stand: lines of "name: what" begin new ones, what is indented is a listing."""
    out, listing = [], False
    if what == "class" and lines:
        text = MADE.sub("", lines[0])
        lines[0] = text[0].upper() + text[1:] if MADE.match(lines[0]) else text
    for line in map(shorter, lines):
        indented = line.startswith("    ")
        if indented and not listing:
            out += ["", "::", ""]
        if line:
            listing = indented
        if listing or not line:
            out.append(line)
            continue
        line = re.sub(r"([*|`])", r"\\\1", line)
        named = re.match(r"([\w, ]{1,40}): (?!:)(.*)", line)
        out += ["", f"**{named[1]}**: {named[2]}"] if named else [line]
    lines[:] = out


def tool_shapes(app, docname, source):
    """Every tool shape where a page says so."""
    classes = (f".. autoclass:: {shape.capitalize()}" for shape in sorted(kibori.SHAPES))
    source[0] = source[0].replace(".. every tool shape", "\n".join(classes))


def setup(app):
    app.connect("source-read", tool_shapes)
    app.connect("autodoc-process-signature", signature)
    app.connect("autodoc-process-docstring", lines_of)
