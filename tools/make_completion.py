#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the bash completion of the kibori command, from its own help.

Usage: make_completion.py KIBORI
"""
import re
import subprocess
import sys


def help_of(program, *command):
    return subprocess.run([program, *command, "--help"], capture_output=True, text=True, check=True).stdout


def options_of(text):
    return sorted(set(re.findall(r"(?:^\s+|,)(--[a-z][a-z-]*)", text, re.MULTILINE)))


def main():
    program = sys.argv[1]
    top = help_of(program)
    commands = re.findall(r"^  ([a-z]+) +[A-Z]", top[top.index("Subcommands:") :], re.MULTILINE)
    print("# Completion of kibori for bash; written by tools/make_completion.py.")
    print("_kibori() {")
    print('  local word=${COMP_WORDS[COMP_CWORD]} choices=')
    print("  case ${COMP_WORDS[1]} in")
    for command in commands:
        print(f"    {command}) choices='{' '.join(options_of(help_of(program, command)))}' ;;")
    print("  esac")
    print(f"  [ \"$COMP_CWORD\" -gt 1 ] || choices='{' '.join(commands + options_of(top))}'")
    print('  mapfile -t COMPREPLY < <(compgen -W "$choices" -- "$word")')
    print("}")
    print("complete -o default -F _kibori kibori")


if __name__ == "__main__":
    main()
