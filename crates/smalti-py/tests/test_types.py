"""The stubs say what the module has, and what is written with it is typed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from conftest import ROOT


def test_stubs_and_module_agree(tmp_path: Path) -> None:
    # PyO3 lists a module's own names.
    (tmp_path / "allowed").write_text("smalti._smalti.__all__\n")
    check = [sys.executable, "-m", "mypy.stubtest", "smalti", "--concise", "--allowlist", str(tmp_path / "allowed")]
    done = subprocess.run(check, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_mypy_finds_nothing(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", ROOT / "pyproject.toml", "--cache-dir", tmp_path],
        capture_output=True, text=True, cwd=ROOT,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
