"""What the tests share: a cache of their own, and the command where it is built."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
Command = Callable[..., str]

# A study of so many sets of filters and mosaics for each number of colours.
STUDY = """
name = "small"
camera = "table1"
colors = [3, 4]
[sample]
filters = {sets}
mosaics = {mosaics}
[filters.gaussian_grid]
[mosaics.tile]
rows = 2
cols = 3
[conditions.grid]
luminance_cd_m2 = [20, 75]
"exposure.time_ms" = [10]
"""


def parts(folder: Path) -> dict[str, bytes]:
    """The files of results, by their names."""
    return {p.name: p.read_bytes() for p in (folder / "trials").iterdir()}


def whole_parts(folder: Path) -> dict[str, bytes]:
    """The same while something may still be written there: the parts that are whole."""
    return {p.name: p.read_bytes() for p in (folder / "trials").glob("part-*.parquet")}


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> None:
    os.environ["SMALTI_CACHE_DIR"] = str(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="session")
def command() -> Command:
    """Runs the `smalti` command that came with the package and gives what it prints."""
    program = Path(sys.executable).with_name("smalti")

    def run(*args: object, code: int = 0) -> str:
        done = subprocess.run([program, *map(str, args)], capture_output=True, text=True, timeout=300)
        assert done.returncode == code, done.stderr
        return done.stdout if code == 0 else done.stderr

    return run
