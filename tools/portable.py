"""Compares results of other machines with those of the first: tools/portable.py FOLDER FIRST OTHER...

Fails where they differ by more than docs/reliability.md states.
"""

import json
import sys
from array import array
from pathlib import Path

# The share of samples of a capture that differ. Where the last bits of a mean decide whether a Poisson deviate is accepted, another one is
# drawn, and the sample differs by as much as noise.
SHARE = 2e-4
# A figure, in parts of itself, or of 1 where it is smaller.
FIGURE = 1e-3


def numbers(value, path=""):
    """Every number of a JSON value, with its path."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from numbers(item, f"{path}.{key}")
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from numbers(item, f"{path}[{i}]")
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield path, value


def figures(folder):
    return {
        f"{name}{path}": value
        for name in ("metrics.json", "evaluate.json")
        for path, value in numbers(json.loads((folder / name).read_text()))
        if "arithmetic" not in path
    }


def samples(folder):
    """The samples of a DNG that Smalti writes, which are the end of the file, 16 bits each."""
    raw = json.loads((folder / "metrics.json").read_text())["raw"]
    data = (folder / "raw.dng").read_bytes()
    return array("H", data[len(data) - 2 * raw["rows"] * raw["cols"] :])


def main():
    work, first, *others = Path(sys.argv[1]), *sys.argv[2:]
    own, capture = figures(work / first), samples(work / first)
    failed = False
    for other in others:
        theirs, raw = figures(work / other), samples(work / other)
        if theirs.keys() != own.keys() or len(raw) != len(capture):
            raise SystemExit(f"{other} has other keys or another size than {first}")
        apart = [abs(a - b) for a, b in zip(capture, raw)]
        key = max(own, key=lambda k: abs(own[k] - theirs[k]) / max(1, abs(own[k])))
        worst = abs(own[key] - theirs[key]) / max(1, abs(own[key]))
        print(
            f"{other} and {first}: {sum(map(bool, apart))} of {len(apart)} samples differ, by {max(apart)} DN at most; "
            f"figures by {worst:.1e} at most ({key}: {own[key]}, {theirs[key]})"
        )
        failed |= sum(map(bool, apart)) > SHARE * len(apart) or worst > FIGURE
    if failed:
        raise SystemExit(f"more than {SHARE} of the samples or {FIGURE} of a figure")


main()
