"""Compares reference values that make_reference.m has made (OUT) with those of the repository (DATA).

    python3 compare.py DATA OUT [--some]

Prints one line per file and exits with 1 when a number differs by more than it may, or when OUT lacks a file; with --some, OUT
may lack files. Only numbers are compared.

A deterministic array may differ by 1e-5 of its largest value: ISETCam stores single precision. Colour differences may
differ by 1e-5 of 100, the range of the coordinates that they are differences of. An array that depends on
random numbers has a counterpart in OUT/spread, which holds the standard deviation of each of its elements. The difference
of two such values has sqrt(2) times that deviation; its RMS over the array may be at most 4 times as large as expected
(plus 1e-5 of the largest value, for elements without scatter).
"""

import csv
import json
import math
import sys
from pathlib import Path

PRECISION = 1e-5
SIGMAS = 4.0
CIELAB_RANGE = 100.0
# Centres of patches that lie between two pixels round to either one.
WITHIN_A_PIXEL = "patch_centers_rc"
# With more than three colours the region that ISETCam finds, if any, depends on the draw; it is not made.
FOUND_REGION = "mtf_autorect"


def read(path):
    if path.suffix == ".json":
        return json.loads(path.read_text())
    with path.open() as file:
        return [[float(value) for value in row] for row in csv.reader(file)]


def arrays(value, name=""):
    """The numeric arrays of a file as (name, list of numbers); a list without structs inside is one array."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from arrays(item, f"{name}.{key}" if name else key)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for i, item in enumerate(value):
            yield from arrays(item, f"{name}[{i}]")
    elif numbers := flat(value):
        yield name, numbers


def flat(value):
    if isinstance(value, list):
        return [number for item in value for number in flat(item)]
    if isinstance(value, str):
        return []
    return [math.nan if value is None else float(value)]


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


class File:
    """The largest differences of one file."""

    def __init__(self):
        self.relative = None
        self.sigmas = None
        self.wrong = []

    def compare(self, name, held, made, spread):
        if len(held) != len(made):
            self.wrong.append(f"{name}: {len(made)} numbers, not {len(held)}")
            return
        largest = max(abs(v) for v in held + made)
        if "dE" in name:
            largest = CIELAB_RANGE
        differences = [h - m for h, m in zip(held, made)]
        if name.endswith(WITHIN_A_PIXEL):
            if max(map(abs, differences)) > 1:
                self.wrong.append(f"{name}: more than one pixel apart")
        elif spread is None:
            worst = max(abs(d) for d in differences)
            relative = worst / largest if largest else worst
            self.relative = max(relative, self.relative or 0.0)
            if not relative <= PRECISION:
                self.wrong.append(f"{name}: relative difference {relative:.1e}")
        else:
            expected = math.sqrt(2.0) * rms(spread)
            excess = max(rms(differences) - PRECISION * largest, 0.0)
            sigmas = excess / expected if expected else (math.inf if excess else 0.0)
            self.sigmas = max(sigmas, self.sigmas or 0.0)
            if not sigmas <= SIGMAS:
                self.wrong.append(f"{name}: {sigmas:.1f} times the expected difference")


def main():
    some = sys.argv[3:] == ["--some"]
    if len(sys.argv) != 3 and not some:
        sys.exit("usage: compare.py DATA OUT [--some]")
    data, out = map(Path, sys.argv[1:3])
    print(f"{'file':44} {'deterministic':>14} {'random':>8}")
    failed = False
    for path in sorted(p for p in data.iterdir() if p.suffix in (".json", ".csv")):
        if not (out / path.name).exists():
            if not some:
                print(f"{path.name:44} not made")
                failed = True
            continue
        held, made = dict(arrays(read(path))), dict(arrays(read(out / path.name)))
        spread_path = out / "spread" / path.name
        spread = dict(arrays(read(spread_path))) if spread_path.exists() else {}
        file = File()
        for name in held:
            if name not in made and spread and name.startswith(FOUND_REGION):
                continue
            if name not in made:
                file.wrong.append(f"{name}: not made")
            else:
                file.compare(name or "table", held[name], made[name], spread.get(name))
        relative = "" if file.relative is None else f"{file.relative:.1e}"
        sigmas = "" if file.sigmas is None else f"{file.sigmas:.2f}"
        print(f"{path.name:44} {relative:>14} {sigmas:>8}")
        for line in file.wrong:
            print(f"    {line}")
        failed |= bool(file.wrong)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
