#!/usr/bin/env python3
"""Prints the lines of source of each crate at a commit, without tests, generated tables and vendored files.

    python3 tools/lines.py [COMMIT]

Counts Rust, JavaScript, CSS, C and Python files below `src/` and `python/`. A module under `#[cfg(test)]` at the end of a Rust file
is a test and does not count.
"""

import re
import subprocess
import sys
from collections import Counter

COUNTED = re.compile(r"^crates/([^/]+)/(src|python)/.*\.(rs|js|css|h|pyi?)$")
LEFT_OUT = re.compile(r"/(tests|generated|vendor)/|/tests\.rs$")
TEST_MODULE = re.compile(r"^#\[cfg\(test\)\]\n(#\[.*\]\n)*mod \w+ \{", re.MULTILINE)


def git(*args):
    return subprocess.run(["git", *args], check=True, capture_output=True, text=True).stdout


def main():
    commit = sys.argv[1] if len(sys.argv) > 1 else "HEAD"
    lines = Counter()
    for path in git("ls-tree", "-r", "--name-only", commit, "crates").splitlines():
        crate = COUNTED.match(path)
        if crate and not LEFT_OUT.search(path):
            text = TEST_MODULE.split(git("show", f"{commit}:{path}"), maxsplit=1)[0]
            lines[crate[1]] += text.count("\n")
    for crate, count in sorted(lines.items()):
        print(f"{count:7}  {crate}")
    print(f"{lines.total():7}  total")


main()
