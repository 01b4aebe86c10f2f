#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that the page's sources (web/src) have no circular imports, neither between files nor
between folders. Prints a circle of files and a circle of folders, if there are any, and exits
with 1.

Usage: check_circles.py
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent / "web/src"


def imports(file):
    for path in re.findall(r'(?:from|import) "(\.[^"]*)"', file.read_text()):
        target = (file.parent / path).resolve().with_suffix(".ts")
        if target.exists():
            yield target.relative_to(ROOT)


def circle(graph):
    """Returns the nodes of one circle of a graph, with the first one repeated at the end. Returns an
    empty list if there is none. The graph is {node: set of nodes}."""
    done, path = set(), []

    def visit(node):
        if node in path:
            return path[path.index(node):] + [node]
        if node in done:
            return []
        path.append(node)
        found = next(filter(None, map(visit, sorted(graph.get(node, ())))), [])
        path.pop()
        done.add(node)
        return found

    return next(filter(None, map(visit, sorted(graph))), [])


files, folders = {}, {}
for file in ROOT.rglob("*.ts"):
    name = file.relative_to(ROOT)
    files[name] = set(imports(file))
    folders.setdefault(name.parent, set()).update(other.parent for other in files[name] if other.parent != name.parent)
found = [c for c in (circle(files), circle(folders)) if c]
for nodes in found:
    print("web/src: circular imports: " + " -> ".join(map(str, nodes)) + "; remove one of them")
sys.exit(1 if found else 0)
