"""The analysis of rating experiments."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import smalti

from conftest import Command

# Pairs of an observer: ratings and nothing else.
RATINGS = 12


def answer(experiment: Path, number: int) -> None:
    """An observer who prefers the condition of the higher number in two of three pairs."""
    manifest = json.loads((experiment / "experiment.json").read_text())
    display = {"device_pixel_ratio": 1.0, "screen_px": [1920, 1080]}
    lines: list[dict[str, object]] = [
        {"kind": "observer", "version": 1, "smalti_version": smalti.__version__, "experiment": manifest["id"], "number": number,
         "secret_blake3": f"{number:064}", "consent": True, "display": display, "unix_s": 0},
    ]  # fmt: skip
    pairs = [(0, 1), (1, 2), (0, 2)]
    for i in range(RATINGS):
        left, right = pairs[i % 3]
        trial = {"role": "rating", "scene": 0, "left": {"condition": left}, "right": {"condition": right}}
        choice = "left" if (i + number) % 3 == 0 else "right"
        lines.append({"kind": "shown", "number": i, "trial": trial, "unix_s": 0})
        lines.append({"kind": "answer", "number": i, "choice": choice, "response_ms": 900, "unix_s": 0})
    folder = experiment / "answers"
    folder.mkdir(exist_ok=True)
    (folder / f"observer-{number:04}.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))


def test_ratings_are_those_of_the_command(command: Command, tmp_path: Path) -> None:
    trial = tmp_path / "trial"
    pictures = ["--processing", "bilinear", "--luminance", "1,10,80", "--scene", "dead-leaves?rows=64&cols=64&largest=30", "--side", "64"]
    trials = ["--ratings", RATINGS, "--repeats", "0", "--traps", "0", "--training", "0"]
    command("rate", "init", "bayer", *pictures, *trials, "-o", trial, "-q")
    with pytest.raises(smalti.SmaltiError, match="trial: the experiment has no answers yet"):
        smalti.analyse_ratings(trial)
    for number in (1, 2, 3):
        answer(trial, number)
    found = smalti.analyse_ratings(trial)
    assert found == json.loads(command("rate", "analyse", trial, "--json"))
    scores = [c["jod"]["value"] for c in found["result"]["all"]["conditions"]]
    assert scores == sorted(scores) and found["answers"] == 3 * RATINGS
    assert found == smalti.analyse_ratings(trial, keep_all=True)
    with pytest.raises(FileNotFoundError):
        smalti.analyse_ratings(tmp_path / "none")
