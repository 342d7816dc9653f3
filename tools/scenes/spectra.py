"""Measured reflectances and light spectra in 31 bands of 10 nm."""

import csv
import functools
import pathlib

import numpy as np

DATA = pathlib.Path(__file__).resolve().parent / "data"
TRAINING = pathlib.Path(__file__).resolve().parents[1] / "data/natural_reflectances.csv"
BANDS_NM = np.arange(400.0, 701.0, 10.0)
STEP_NM = 10.0


def _read(name: str) -> dict[str, np.ndarray]:
    with (DATA / name).open() as f:
        rows = list(csv.reader(line for line in f if not line.startswith("#")))
    return {r[0]: np.array([float(v) for v in r[2:]]) for r in rows[1:]}


@functools.cache
def reflectances() -> dict[str, np.ndarray]:
    """Reflectance (0 to 1) by name."""
    return _read("reflectances.csv")


@functools.cache
def training() -> dict[str, np.ndarray]:
    """Reflectances (0 to 1) of the training set by name. No test scene has one of them."""
    with TRAINING.open() as f:
        rows = list(csv.reader(line for line in f if not line.startswith("#")))
    # From 380 nm on, in units of 0.00001.
    return {r[0]: np.array([float(v) / 1e5 for v in r[1:]])[2:33] for r in rows}


@functools.cache
def lights() -> dict[str, np.ndarray]:
    """Relative spectral power by name. E is the equal-energy spectrum."""
    return {**_read("lights.csv"), "E": np.ones(len(BANDS_NM))}


@functools.cache
def observer() -> np.ndarray:
    """CIE 1931 2° colour matching functions, bands × 3."""
    o = _read("observer.csv")
    return np.stack([o[k] for k in "XYZ"], axis=1)


def table(names: list[str]) -> np.ndarray:
    """Reflectances of several materials, of tests or of training, bands × materials."""
    known = {**training(), **reflectances()}
    return np.stack([known[n] for n in names], axis=1)


def luminance(radiance: np.ndarray) -> np.ndarray:
    """Luminance (cd/m²) of spectral radiance (W m⁻² sr⁻¹ nm⁻¹), bands last."""
    return 683.0 * STEP_NM * (radiance @ observer()[:, 1])


def radiance(name: str, cd_m2: float) -> np.ndarray:
    """Spectral radiance (W m⁻² sr⁻¹ nm⁻¹) of a lamp of a given luminance."""
    s = lights()[name]
    return s * (cd_m2 / luminance(s))


def irradiance(name: str, lux: float) -> np.ndarray:
    """Spectral irradiance (W m⁻² nm⁻¹) of a lamp that gives an illuminance in lux."""
    return radiance(name, lux)
