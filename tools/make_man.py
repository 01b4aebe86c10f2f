#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes man pages of the kibori command and its subcommands, with help2man from their own help.

Usage: make_man.py KIBORI FOLDER
"""
import pathlib
import re
import subprocess
import sys


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    top = subprocess.run([program, "--help"], capture_output=True, text=True, check=True).stdout
    commands = re.findall(r"^  ([a-z]+) +([A-Z].*)", top[top.index("Subcommands:") :], re.MULTILINE)
    pages = [("kibori", [], "carve virtual solids by hand and feel them")]
    pages += [(f"kibori-{name}", [name], about.rstrip()[0].lower() + about.rstrip()[1:]) for name, about in commands]
    for page, command, about in pages:
        wrapper = folder / f"{page}.sh"  # help2man needs a program without arguments
        wrapper.write_text(
            f'#!/bin/sh\n[ "$1" = --version ] && exec "{program}" --version\nexec "{program}" {" ".join(command)} --help\n')
        wrapper.chmod(0o755)
        text = subprocess.run(["help2man", "--no-info", "--no-discard-stderr", "--section=1", f"--name={about}",
                               str(wrapper.resolve())], capture_output=True, text=True, check=True).stdout
        wrapper.unlink()
        text = text.replace(f"{page}.sh", page).replace(f"{page.upper()}.SH", page.upper())
        (folder / f"{page}.1").write_text(text)


if __name__ == "__main__":
    main()
