"""Renders a raw image with a learned table by the program that docs/formats-l3.md states, and prints classes and outputs."""

import json
import pathlib
import re
import sys

import numpy as np

docs = pathlib.Path(__file__).resolve().parents[4] / "docs" / "formats-l3.md"
program = re.search(r"```python\n(.*?)```", docs.read_text(encoding="utf-8"), re.DOTALL).group(1)
namespace = {}
exec(program, namespace)

table, image, rows, cols = sys.argv[1:]
samples = np.fromfile(image, "<u2").reshape(int(rows), int(cols))
classes, outputs = namespace["render"](table, samples)
print(json.dumps({"classes": classes.ravel().tolist(), "outputs": outputs.ravel().tolist()}))
