"""`python -m smalti`, and the `smalti` that pip installs: the command itself."""

from __future__ import annotations

import signal
import sys

from ._smalti import command


def main() -> int:
    # Python would hear of Ctrl-C only after the work; the command ends at once, and a sweep after its part.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return command(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
