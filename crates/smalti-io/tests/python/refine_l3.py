"""Refines a picture with a learned table by the program that docs/formats-l3.md states, and prints the result."""

import json
import pathlib
import re
import sys

import numpy as np

docs = pathlib.Path(__file__).resolve().parents[4] / "docs" / "formats-l3.md"
programs = re.findall(r"```python\n(.*?)```", docs.read_text(encoding="utf-8"), re.DOTALL)
namespace = {}
exec(next(p for p in programs if "def refine(" in p), namespace)

table, picture, samples = sys.argv[1:]
print(json.dumps({"outputs": namespace["refine"](table, np.load(picture), np.load(samples)).ravel().tolist()}))
