"""Joins renderings of a scene, measures what noise is left, and stores the scene as components."""

import pathlib
from typing import Any

import numpy as np

from . import codec, spectra

LIMIT = 1_330_000
LOG_STEP = 0.01


def shares_of_error(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Relative spectral error of each pixel: |a − b| / |b| over the bands."""
    return np.linalg.norm(a - b, axis=2) / np.maximum(np.linalg.norm(b, axis=2), 1e-30)


def smooth_and_lit(level: np.ndarray) -> np.ndarray:
    """Pixels above a tenth of the median whose 5 × 5 neighbourhood varies by less than 2 %: there, noise would be seen as texture."""
    windows = np.lib.stride_tricks.sliding_window_view(level, (5, 5))
    vary = windows.std(axis=(2, 3)) / np.maximum(windows.mean(axis=(2, 3)), 1e-30)
    return np.pad(vary < 0.02, 2) & (level > 0.1 * np.median(level))


def choose(image: np.ndarray, limit: int) -> tuple[int, float]:
    """Number of components and step of least error within the size limit."""
    level = image.mean(axis=2)
    floor = max(float(level.max()) * 1e-7, 1e-30)
    flat = (image / np.maximum(level, floor)[:, :, None]).reshape(-1, image.shape[2]).astype(np.float64)
    mean = flat.mean(axis=0)
    _, vectors = np.linalg.eigh((flat - mean).T @ (flat - mean))
    coefficients = (flat - mean) @ vectors[:, ::-1]
    size_level = len(codec.deflate(codec.level_bytes(np.rint(np.log(np.maximum(level, floor) / floor) / LOG_STEP).astype(np.int64))))
    best = (np.inf, 0, 0.0)
    for step in (0.045, 0.055, 0.065, 0.08, 0.095, 0.11, 0.13):
        q = np.rint(coefficients[:, :16] / step)
        size = size_level
        for k in range(16):
            size += len(codec.deflate(codec.coefficient_bytes(q[:, k].astype(np.int64).reshape(level.shape))))
            if size > limit - 6000:
                break
            if k < 5:
                continue
            shape = np.maximum(mean + q[:, : k + 1] * step @ vectors[:, ::-1][:, : k + 1].T, 0)
            error = np.linalg.norm(shape - flat, axis=1) / np.linalg.norm(flat, axis=1)
            best = min(best, (float(np.median(error) + np.percentile(error, 95)), k + 1, step))
    return best[1], best[2]


def store(module: Any, name: str, folder: pathlib.Path, out: pathlib.Path) -> dict[str, object]:
    """Writes out/NAME.spc of a scene of a script; the parts in `folder` are independent estimates of the same picture."""
    files = sorted(folder.glob(f"{name}-*.npz"))
    parts = [np.load(f) for f in files]
    weights = np.array([float(p["spp"]) for p in parts])
    weights /= weights.sum()
    clean = [p["clean"].astype(np.float64) for p in parts]
    image = sum(w * c for w, c in zip(weights, clean)).astype(np.float32)
    level = image.mean(axis=2)
    noise: dict[str, object] = {}
    if len(parts) > 1:
        # Variance of the weighted mean from the scatter of the parts.
        scatter = sum(w * (c - image) ** 2 for w, c in zip(weights, clean)) * (weights**2).sum() / (1 - (weights**2).sum())
        spectral = np.sqrt(scatter.sum(axis=2)) / np.maximum(np.linalg.norm(image, axis=2), 1e-30)
        smooth = smooth_and_lit(level)
        noise = {
            "smooth_lit_share": round(float(smooth.mean()), 3),
            "smooth_lit_rms": round(float(np.sqrt((spectral[smooth] ** 2).mean())), 4),
            "lit_median": round(float(np.median(spectral[level > 0.1 * np.median(level)])), 4),
        }
    light = parts[0]["white"].astype(np.float64)
    if module.WHITE != "probe":
        light = light * (np.percentile(spectra.luminance(image), 99) / spectra.luminance(light))
    components, step = choose(image, getattr(module, "LIMIT", LIMIT))
    about: dict[str, object] = {
        "name": name,
        "title": module.TITLE,
        "quantity": "radiance",
        "unit": "W m^-2 sr^-1 nm^-1",
        "samples_per_pixel": int(sum(float(p["spp"]) for p in parts)),
        "licence": "see tools/scenes/README.md",
    }
    data = codec.encode(image, light, about, components, LOG_STEP, step)
    (out / f"{name}.spc").write_bytes(data)
    error = shares_of_error(codec.decode(data).radiance, image)
    luminance = spectra.luminance(image)
    return {
        **about,
        "bytes": len(data),
        "components": components,
        "step": step,
        "error_median": round(float(np.median(error)), 4),
        "error_95": round(float(np.percentile(error, 95)), 4),
        "error_rms": round(float(np.sqrt((error**2).mean())), 4),
        "noise": noise,
        "seconds": round(sum(float(p["seconds"]) for p in parts)),
        "luminance_percentiles_1_50_99": [round(float(v), 3) for v in np.percentile(luminance, [1, 50, 99])],
    }
