#!/usr/bin/env python3
"""Compares Bayer demosaicking and learned pipelines with OpenCV on the same 4K frames of 16 bits, with two threads, in turns.

    cargo bench -p smalti --bench demosaic --bench l3 --no-run
    python3 tools/bench_opencv.py [--rounds 5] [--only l3]

The script prints the throughput of bilinear demosaicking and its ratio to OpenCV's `cvtColor(COLOR_BayerRGGB2RGB)`. It also prints the
throughput of rendering with a learned table (classification included) and its ratio to OpenCV's edge-aware `COLOR_BayerRGGB2RGB_EA`.
It needs numpy and opencv-python-headless. Other load on the machine slows all of them alike. The rounds therefore
alternate, and the ratio of the medians is the result.
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
ROOT = pathlib.Path(__file__).resolve().parent.parent


def noise():
    return np.random.default_rng(1).integers(0, 65536, (ROWS, COLS), dtype=np.uint16)


def picture():
    """The frame of `benches/l3.rs`: from dark to clipped, with edges and noise."""
    row, col = np.ogrid[:ROWS, :COLS]
    i = np.arange(ROWS * COLS, dtype=np.uint64).reshape(ROWS, COLS)
    grain = ((i * np.uint64(2654435761)) >> np.uint64(16)).astype(np.int64) & 1023
    light = row * (col + 400) * 40000 // (ROWS * (COLS + 400))
    edges = 1 + (row // 64 + col // 96) % 2
    return np.minimum(256 + light * edges + grain, 65535).astype(np.uint16)


# Criterion's group: OpenCV's conversion, its name, the frame.
AGAINST = {
    "demosaic": ("demosaic 3840x2160", cv2.COLOR_BayerRGGB2RGB, "OpenCV bilinear u16", noise),
    "l3": ("l3 3840x2160", cv2.COLOR_BayerRGGB2RGB_EA, "OpenCV edge-aware u16", picture),
}


def opencv_seconds(code, raw, into, repeats=30):
    """Median time of one conversion, into an array that exists already or into a new one."""
    out = np.empty((ROWS, COLS, 3), np.uint16) if into else None
    cv2.setNumThreads(2)
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        cv2.cvtColor(raw, code, out)
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def smalti_seconds(bench, group):
    """Median time by benchmark name, from the files of Criterion."""
    subprocess.run(
        ["cargo", "bench", "-q", "-p", "smalti", "--bench", bench, "--",
         "--warm-up-time", "0.5", "--measurement-time", "2", "--noplot"],
        cwd=ROOT, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )
    found = {}
    for path in (ROOT / "target/criterion").glob("*/*/new/benchmark.json"):
        about = json.loads(path.read_text())
        if about["group_id"] == group:
            estimates = json.loads((path.parent / "estimates.json").read_text())
            found[about["function_id"]] = estimates["median"]["point_estimate"] * 1e-9
    return found


def roofline(name, rate):
    """The minimum work of a pixel of a learned pipeline: multiply-adds of three kernels and their offsets, bytes of the raw
    samples and of three planes."""
    side = int(name.split("x")[-1])
    macs, bytes_ = 3 * (side * side + 1), 2 + 3 * 4
    return (f"  per pixel {macs} multiply-adds, {bytes_} bytes: "
            f"{rate * macs * 1e-3:.0f} G/s, {rate * bytes_ * 1e-3:.1f} GB/s")


def compare(bench, rounds):
    group, code, name, frame = AGAINST[bench]
    raw = frame()
    theirs, anew, ours = [], [], {}
    for turn in range(rounds + 1):
        theirs.append(opencv_seconds(code, raw, into=True))
        anew.append(opencv_seconds(code, raw, into=False))
        if turn < rounds:
            for what, seconds in smalti_seconds(bench, group).items():
                ours.setdefault(what, []).append(seconds)
    base = statistics.median(theirs)
    megapixels = ROWS * COLS * 1e-6
    print(f"{name:28} {megapixels / base:7.0f} MP/s  ({megapixels / statistics.median(anew):.0f} into a new array)")
    for what, seconds in sorted(ours.items()):
        median = statistics.median(seconds)
        rate = megapixels / median
        limits = roofline(what, rate) if bench == "l3" else ""
        print(f"{what:28} {rate:7.0f} MP/s  {base / median:5.2f} × OpenCV{limits}")


def main():
    args = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    args.add_argument("--rounds", type=int, default=3)
    args.add_argument("--only", choices=list(AGAINST))
    args = args.parse_args()
    for bench in [args.only] if args.only else AGAINST:
        compare(bench, args.rounds)


if __name__ == "__main__":
    main()
