#!/usr/bin/env python3
"""Peaks at the frequencies of the tile in pictures of a noisy uniform grey, rendered by pipelines of quality `best`.

    python3 tools/tile_peaks.py [CAMERA …]    # default: bayer; needs the Python package and NumPy

For each luminance it prints the largest peak in standard deviations of the spectrum around it, the root mean square over all peaks (1 where there is
noise alone), and the largest amplitude relative to the mean.
"""

import sys

import numpy as np
import smalti

SIZE = 384
AROUND = 6


def peaks(plane: np.ndarray, tile: tuple[int, int]) -> np.ndarray:
    """Amplitude / σ, and amplitude / mean, of every frequency of the tile but 0."""
    spectrum = np.fft.fft2(plane)
    power = np.abs(spectrum) ** 2
    power[0, 0] = np.nan
    rows, cols = plane.shape
    found = []
    for i, j in np.ndindex(*tile):
        if (i, j) == (0, 0):
            continue
        row, col = i * rows // tile[0], j * cols // tile[1]
        near = np.arange(-AROUND, AROUND + 1)
        block = power[np.ix_((row + near) % rows, (col + near) % cols)].copy()
        block[AROUND, AROUND] = np.nan
        amplitude = np.abs(spectrum[row, col])
        found.append([amplitude / np.sqrt(np.nanmean(block)), amplitude / np.abs(spectrum[0, 0])])
    return np.array(found)


def main() -> None:
    for name in sys.argv[1:] or ["bayer"]:
        camera = smalti.Camera(name)
        pipeline = smalti.train(camera, illuminants=["D65"], quality="best")
        tile = camera.cfa.tile.shape
        size = [SIZE // n * n for n in tile]
        large = camera.with_size(*size)
        for luminance in [1, 10, 80]:
            scene = smalti.Scene("uniform", luminance_cd_m2=luminance, wavelengths_nm=camera.wavelengths_nm)
            found = []
            for seed in range(1, 5):
                photo = large.photograph(scene, pipeline=pipeline, seed=seed, full_frame=True)
                picture = photo.picture.array.astype(float)
                found += [peaks(picture[..., plane], tile) for plane in range(3)]
            sigma, amplitude = np.array(found).reshape(-1, 2).T
            rms = np.sqrt(np.mean(sigma**2))
            largest = f"largest {sigma.max():.1f} σ, root mean square {rms:.2f} σ"
            print(f"{name}, {luminance} cd/m²: {largest}, amplitude {100 * amplitude.max():.4f} %")


if __name__ == "__main__":
    main()
