"""The `smalti` command, as a program and for calls from Python."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence

from . import _smalti


def main() -> int:
    """The entry point of `python -m smalti` and of the `smalti` that pip installs."""
    # Python would handle Ctrl-C only after the work; this way the command ends at once, and a sweep reports how to resume.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if not hasattr(_smalti, "run_command"):
        print("error: this build of the package has no command; build it with the feature `command`", file=sys.stderr)
        return 1
    return _smalti.run_command(sys.argv[1:])


def command(args: Sequence[str | os.PathLike[str]]) -> int:
    """Runs the `smalti` command in a new process and returns its exit code: 0 success, 1 failure, 2 wrong usage.

    Results are written to standard output, progress and messages to standard error. Where Python redirects these streams, as in
    Jupyter, the output is printed when the command ends. Ctrl-C ends the command.

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
