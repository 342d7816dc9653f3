"""Scales choices with choix: the argument is a JSON file with `conditions` and `choices`, a list of [preferred, other]. Prints the
parameters of the model of Bradley and Terry, whose mean is 0, as a JSON list."""

import json
import sys

import choix
import numpy as np

with open(sys.argv[1], encoding="utf-8") as file:
    data = json.load(file)
scores = choix.opt_pairwise(data["conditions"], [tuple(c) for c in data["choices"]], alpha=0.0, tol=1e-10)
print(json.dumps(list(scores - np.mean(scores))))
