"""The `smalti` command: as a program, and called from Python."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence

from . import _smalti


def main() -> int:
    """`python -m smalti`, and the `smalti` that pip installs."""
    # Python would hear of Ctrl-C only after the work; the command ends at once, and a sweep says how it goes on.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _smalti.run_command(sys.argv[1:])


def command(args: Sequence[str | os.PathLike[str]]) -> int:
    """Runs the `smalti` command in a process of its own, and returns its exit code: 0 done, 1 failed, 2 wrong usage.

    Results go to standard output, progress and messages to standard error; where Python's own are elsewhere, as in Jupyter, they are
    printed there in the end. Ctrl-C ends the command.

    Args:
        args: the command line without the name of the program: `["compare", "bayer", "rgbw", "-o", "out"]`.
    """
    line = [sys.executable, "-m", "smalti", *(os.fspath(a) for a in args)]
    if sys.stdout is sys.__stdout__ and sys.stderr is sys.__stderr__:
        return subprocess.run(line).returncode
    done = subprocess.run(line, capture_output=True, text=True, encoding="utf-8")
    sys.stdout.write(done.stdout)
    sys.stderr.write(done.stderr)
    return done.returncode
