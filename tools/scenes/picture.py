"""Renditions in sRGB, to look at."""

import pathlib

import numpy as np
from PIL import Image

from . import spectra

_TO_SRGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])


def srgb(radiance: np.ndarray, white: np.ndarray, percentile: float = 99.0, key: float = 0.85) -> np.ndarray:
    """8-bit sRGB; `white` (bands) becomes neutral, the given percentile of luminance becomes `key`."""
    xyz = radiance @ spectra.observer()
    w = white @ spectra.observer()
    xyz = xyz * (np.array([0.9505, 1.0, 1.089]) / w * w[1])
    rgb = xyz @ _TO_SRGB.T
    rgb *= key / np.percentile(xyz[..., 1], percentile)
    # A shoulder above 0.8 keeps highlights from clipping hard.
    rgb = np.where(rgb > 0.8, 0.8 + 0.2 * np.tanh((rgb - 0.8) / 0.2), rgb)
    rgb = np.clip(rgb, 0, 1)
    return (255 * np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - 0.055) + 0.5).astype(np.uint8)


def save(path: pathlib.Path, radiance: np.ndarray, white: np.ndarray, percentile: float = 99.0) -> None:
    """Writes a PNG."""
    Image.fromarray(srgb(radiance, white, percentile)).save(path)
