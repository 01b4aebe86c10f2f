#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measures the servo loop with and without readers of its ticks, in turn: the cost of publishing,
and the ticks that readers miss. Also measures the loop in a script. There, Python threads hold
the lock (GIL), or separate processes do the same work.

Usage: publish_loop.py KIBORI [--json] [--quick] [--seconds S]; PYTHONPATH must contain the
module. Topics over DDS are written if kibori_dds.so exists. Nobody reads them here.
"""
import json
import os
import statistics
import subprocess
import sys
import threading
import time

import numpy as np

import kibori as kb

quick = "--quick" in sys.argv
seconds = float(sys.argv[sys.argv.index("--seconds") + 1]) if "--seconds" in sys.argv else 0.5 if quick else 20
rounds = 1 if quick else 5
kibori = sys.argv[1]
dds = os.path.exists(os.path.join(os.path.dirname(kibori), "kibori_dds.so"))
SETUPS = {"nobody": [], "a reader": ["127.0.0.1:0"]} | ({"a reader, DDS": ["127.0.0.1:0", "dds:97"]} if dds else {})


def run(places):
    program = subprocess.Popen([kibori, "servo", "--json", "--seconds", str(seconds), *(a for p in places for a in ("--publish", p))],
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    read = {"rows": 0, "lost": 0, "first": 0}
    if places:
        address = program.stderr.readline().split("ws://")[1].split()[0]

        def listens():
            with kb.listen(address) as ticks:
                for rows in ticks:
                    read["first"] = read["first"] or int(rows["tick"][0])
                    read["rows"] += len(rows)
                read["lost"] = ticks.lost
        reader = threading.Thread(target=listens)
        reader.start()
    report = json.loads(program.communicate()[0])
    if places:
        reader.join()
    return report, read


def in_script(busy_threads, busy_processes):
    """Runs the loop of Model.servo() with the same hand and block while others keep Python busy."""
    done = threading.Event()

    def burn():
        while not done.is_set():
            sum(range(1000))

    threads = [threading.Thread(target=burn) for _ in range(busy_threads)]
    processes = [subprocess.Popen([sys.executable, "-c", "while True: sum(range(1000))"]) for _ in range(busy_processes)]
    for thread in threads:
        thread.start()
    rows = []
    with kb.Model.block((80, 50, 30), 0.25, "oak").servo(kb.Ball(4), at=(5, 25, 40)) as servo:
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            share = 1 - left / seconds
            servo.aim((5 + 70 * share, 25, 29))
            rows.append(servo.ticks())
            time.sleep(0.01)
    rows.append(servo.ticks())
    done.set()
    for thread in threads:
        thread.join()
    for process in processes:
        process.kill()
        process.wait()
    numbers = np.concatenate([r["tick"] for r in rows]).astype(int)
    s = servo.statistics
    return {"compute_p50_us": s["compute_us"]["p50"], "compute_p999_us": s["compute_us"]["p999"], "late_p999_us": s["late_us"]["p999"],
            "empty_loop_late_p999_us": 0, "missed": s["missed"], "ticks": s["ticks"], "read": len(numbers),
            "lost": int((np.diff(numbers) - 1).sum())}


SCRIPTS = {"in a script": (0, 0), "2 busy threads": (2, 0), "2 processes": (0, 2)}
took = {setup: [] for setup in [*SETUPS, *SCRIPTS]}
for _ in range(rounds):
    for setup, busy in SCRIPTS.items():
        took[setup].append(in_script(*busy))
    for setup, places in SETUPS.items():
        report, read = run(places)
        took[setup].append({"compute_p50_us": report["compute_us"]["p50"], "compute_p999_us": report["compute_us"]["p999"],
                          "late_p999_us": report["late_us"]["p999"], "empty_loop_late_p999_us": report["empty_loop_late_us"]["p999"],
                          "missed": report["missed"], "ticks": report["ticks"], "read": read["rows"], "lost": read["lost"]})
median = {setup: {name: statistics.median(run[name] for run in runs) for name in runs[0]} for setup, runs in took.items()}
if "--json" in sys.argv:
    print(json.dumps(median))
else:
    print(f"servo loop, {seconds:g} s each, medians of {rounds}; p99.9 of what it computes and of how late it begins [us]")
    for setup, m in median.items():
        empty = f" (an empty loop: {m['empty_loop_late_p999_us']:7.1f})" if m["empty_loop_late_p999_us"] else " " * 26
        print(f"{setup:14} compute p50 {m['compute_p50_us']:6.1f} p99.9 {m['compute_p999_us']:7.1f}   late p99.9 {m['late_p999_us']:7.1f}{empty}"
              f"   missed {m['missed']:g} of {m['ticks']:g}   read {m['read']:g}, lost {m['lost']:g}")
