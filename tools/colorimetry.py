#!/usr/bin/env python3
"""Writes crates/smalti/tests/data/colorimetry/expected.json: Vora value, sensitivity metamerism index and metamer mismatch of measured cameras.

    python3 tools/colorimetry.py

This is an independent computation with NumPy and SciPy, with which a test compares smalti's. It takes sensitivities from tools/data/curves,
and observer, light D65 and ColorChecker from colour-science. It differs from smalti in its methods as well: the Vora value comes from QR
decompositions, the colour matrix from a general minimisation with several starts, and the metamer mismatch from a linear programme over
reflectances.
"""
import json
import pathlib

import colour
import numpy as np
from scipy.optimize import linprog, minimize

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "crates/smalti/tests/data/colorimetry/expected.json"
NM = np.arange(400.0, 701.0, 10.0)

CASES = {
    "canon-eos-5d-mark-ii": ["canon-eos-5d-mark-ii"],
    "sony-ilce-7rm2": ["sony-ilce-7rm2"],
    "imx219": ["imx219"],
    "canon-eos-5d-mark-ii and a clear channel": ["canon-eos-5d-mark-ii", "flat"],
    "canon-eos-5d-mark-ii and imx219": ["canon-eos-5d-mark-ii", "imx219"],
}


def channels(name):
    """Response per photon, a column per channel."""
    if name == "flat":
        return np.ones((len(NM), 1))
    rows = np.loadtxt(ROOT / f"tools/data/curves/{name}.csv", delimiter=",")
    return np.stack([np.interp(NM, rows[:, 0], c) for c in rows[:, 1:].T], axis=1)


def sampled(distribution):
    table = colour.utilities.as_float_array(distribution.values)
    own = distribution.wavelengths
    return np.stack([np.interp(NM, own, c) for c in np.atleast_2d(table.T)], axis=1)


def vora(sensor, observer):
    # Per power: the photons in a joule are proportional to the wavelength.
    s, _ = np.linalg.qr(sensor * NM[:, None])
    v, _ = np.linalg.qr(observer)
    return np.trace(s @ s.T @ v @ v.T) / 3


def index(sensor, photons, observer_per_photon, patches):
    white = observer_per_photon.T @ photons
    scale = 100 / white[1]
    xyz = scale * (patches * photons[:, None]).T @ observer_per_photon
    camera = (patches * photons[:, None]).T @ sensor
    camera /= np.abs(camera).max(axis=0)

    def lab(values):
        t = values / (white * scale)
        f = np.where(t > 216 / 24389, np.cbrt(t), (24389 / 27 * t + 16) / 116)
        return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)

    expected = lab(xyz)

    def mean(matrix):
        return np.mean(np.linalg.norm(lab(camera @ matrix.reshape(-1, 3)) - expected, axis=1))

    start = np.linalg.lstsq(camera, xyz, rcond=None)[0].ravel()
    best = np.inf
    for seed in range(6):
        jitter = np.random.default_rng(seed).normal(1.0, 0.05 if seed else 0.0, start.size)
        found = start * jitter
        for _ in range(4):
            found = minimize(mean, found, method="Powell", options={"maxiter": 20000, "xtol": 1e-8, "ftol": 1e-12}).x
            found = minimize(mean, found, method="Nelder-Mead", options={"maxiter": 40000, "xatol": 1e-9, "fatol": 1e-11, "adaptive": True}).x
        best = min(best, mean(found))
    return 100 - 5.5 * best


def mismatch(sensor, photons, observer_per_photon):
    """Percent along X, Y, Z: the largest difference from mid grey of a reflectance that the sensor cannot tell from it."""
    seen = (sensor * photons[:, None]).T
    percent = []
    for function in (observer_per_photon * photons[:, None]).T:
        # Maximises function · s over |s| <= 1 with seen · s = 0.
        found = linprog(-function / function.sum(), A_eq=seen / np.abs(seen).sum(axis=1, keepdims=True), b_eq=np.zeros(len(seen)), bounds=(-1, 1), method="highs")
        assert found.success, found.message
        percent.append(-100 * found.fun)
    return percent


def main():
    observer = sampled(colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"])
    photons = sampled(colour.SDS_ILLUMINANTS["D65"])[:, 0] * NM
    per_photon = observer / NM[:, None]
    chart = list(colour.SDS_COLOURCHECKERS["BabelColor Average"].values())[:18]
    patches = np.concatenate([sampled(p) for p in chart], axis=1)
    cases = []
    for name, parts in CASES.items():
        sensor = np.concatenate([channels(p) for p in parts], axis=1)
        cases.append({
            "name": name,
            "filters": parts,
            "vora_value": round(float(vora(sensor, observer)), 7),
            "sensitivity_metamerism_index": round(float(index(sensor, photons, per_photon, patches)), 5),
            "metamer_mismatch_percent": [round(float(v), 6) for v in mismatch(sensor, photons, per_photon)],
        })
        print(cases[-1], flush=True)
    OUT.parent.mkdir(parents=True, exist_ok=True)
    OUT.write_text(json.dumps(cases, indent=2) + "\n")


main()
