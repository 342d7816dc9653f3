#!/usr/bin/env python3
"""Bayer demosaicking beside OpenCV's: the same 4K frame, 16 bits, two threads, in turns.

    cargo bench -p smalti --bench demosaic --no-run
    python3 tools/bench_opencv.py [--rounds 5]

Prints the throughput of each and its ratio to OpenCV's `cvtColor(COLOR_BayerRGGB2RGB)`. Needs numpy and
opencv-python-headless. Other work on the machine slows all of them alike, which is why the rounds alternate and
the ratio of medians is what counts.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import time

import cv2
import numpy as np

ROWS, COLS = 2160, 3840
GROUP = "demosaic 3840x2160"
ROOT = pathlib.Path(__file__).resolve().parent.parent


def opencv_seconds(repeats=30):
    """Median time of one conversion into an array that exists already."""
    raw = np.random.default_rng(1).integers(0, 65536, (ROWS, COLS), dtype=np.uint16)
    out = np.empty((ROWS, COLS, 3), np.uint16)
    cv2.setNumThreads(2)
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        cv2.cvtColor(raw, cv2.COLOR_BayerRGGB2RGB, out)
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def smalti_seconds():
    """Median time by benchmark name, from Criterion's own files."""
    subprocess.run(
        ["cargo", "bench", "-q", "-p", "smalti", "--bench", "demosaic", "--",
         "--warm-up-time", "0.5", "--measurement-time", "2", "--noplot"],
        cwd=ROOT, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )
    found = {}
    for path in (ROOT / "target/criterion").glob("*/*/new/benchmark.json"):
        about = json.loads(path.read_text())
        if about["group_id"] == GROUP:
            estimates = json.loads((path.parent / "estimates.json").read_text())
            found[about["function_id"]] = estimates["median"]["point_estimate"] * 1e-9
    return found


def main():
    args = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    args.add_argument("--rounds", type=int, default=3)
    rounds = args.parse_args().rounds
    theirs, ours = [], {}
    for _ in range(rounds):
        theirs.append(opencv_seconds())
        for name, seconds in smalti_seconds().items():
            ours.setdefault(name, []).append(seconds)
    theirs.append(opencv_seconds())
    base = statistics.median(theirs)
    megapixels = ROWS * COLS * 1e-6
    print(f"{'OpenCV bayer u16':28} {megapixels / base:7.0f} MP/s")
    for name, seconds in sorted(ours.items()):
        median = statistics.median(seconds)
        print(f"{name:28} {megapixels / median:7.0f} MP/s  {base / median:5.2f} × OpenCV")


if __name__ == "__main__":
    main()
