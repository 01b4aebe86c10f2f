#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs clang-tidy on the .cpp files changed against the main branch's previous commit (or uncommitted).

Usage: tidy_changed.py BUILD_DIR. Vector kernels are left out: clang-tidy does not follow Highway's per-target includes.
"""
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile


def git(*arguments):
    return subprocess.run(("git", *arguments), capture_output=True, text=True).stdout.split()


def changed():
    files = set(git("diff", "--name-only", "HEAD", "--", "*.cpp"))
    files |= set(git("ls-files", "--others", "--exclude-standard", "*.cpp"))
    if git("rev-parse", "--verify", "-q", "HEAD~1"):
        files |= set(git("diff", "--name-only", "HEAD~1", "HEAD", "--", "*.cpp"))
    return sorted(f for f in files if pathlib.Path(f).exists() and f.startswith(("kibori/", "apps/")))


def without_precompiled_headers(build, folder):
    """Writes the build's compile commands without GCC's precompiled headers, which clang cannot read, to a folder."""
    commands = json.loads((pathlib.Path(build) / "compile_commands.json").read_text())
    for command in commands:
        command["command"] = re.sub(r" -Winvalid-pch| -fpch-preprocess| -include \S*cmake_pch\.hxx", "", command["command"])
    (pathlib.Path(folder) / "compile_commands.json").write_text(json.dumps(commands))


def main():
    files = [f for f in changed() if "foreach_target" not in pathlib.Path(f).read_text()]
    print(f"{len(files)} files")
    if not files:
        return 0
    with tempfile.TemporaryDirectory() as folder:
        without_precompiled_headers(sys.argv[1], folder)

        def tidy(file):
            run = subprocess.run(
                ["clang-tidy-14", "--quiet", "-p", folder, file], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
            )
            return run.returncode, run.stdout

        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as workers:
            outcomes = list(workers.map(tidy, files))
    for _, said in outcomes:
        print(said, end="")
    return max(code for code, _ in outcomes)


if __name__ == "__main__":
    sys.exit(main())
