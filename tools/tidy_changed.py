#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs clang-tidy on the .cpp files of kibori/ and apps/ that the last commit changed, and on those with uncommitted
changes.

Usage: tidy_changed.py. Skips vector kernels, because clang-tidy does not follow Highway's per-target includes.
Configures build/tidy, where each source is compiled alone. Builds nothing there.
"""
import concurrent.futures
import os
import pathlib
import subprocess
import sys


def git(*arguments):
    return subprocess.run(("git", *arguments), capture_output=True, text=True).stdout.split()


def changed():
    files = set(git("diff", "--name-only", "HEAD", "--", "*.cpp"))
    files |= set(git("ls-files", "--others", "--exclude-standard", "*.cpp"))
    if git("rev-parse", "--verify", "-q", "HEAD~1"):
        files |= set(git("diff", "--name-only", "HEAD~1", "HEAD", "--", "*.cpp"))
    return sorted(f for f in files if pathlib.Path(f).exists() and f.startswith(("kibori/", "apps/")))


BUILD = "build/tidy"


def configure():
    options = ("-DKIBORI_UNITE=OFF", "-DKIBORI_TESTS=ON", "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON")
    subprocess.run(("cmake", "--preset", "release", "-B", BUILD, *options), stdout=subprocess.DEVNULL, check=True)


def main():
    files = [f for f in changed() if "foreach_target" not in pathlib.Path(f).read_text()]
    print(f"{len(files)} files")
    if not files:
        return 0
    configure()

    def tidy(file):
        run = subprocess.run(
            ["clang-tidy-14", "--quiet", "-p", BUILD, file], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        return run.returncode, run.stdout

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as workers:
        outcomes = list(workers.map(tidy, files))
    for _, output in outcomes:
        print(output, end="")
    return max(code for code, _ in outcomes)


if __name__ == "__main__":
    sys.exit(main())
