#!/usr/bin/env python3
"""Compares the colours of L³ on uniform patches with those of the best matrix that a camera can have.

    pip install . numpy
    python3 tools/compare_matrix.py

The patches are those of the ColorChecker under D65. L³ of quality `best` has learned from other scenes. The rival is a matrix from the camera's channels to X, Y, Z that is
fitted to these very patches at each luminance, with the noise of their samples in mind: it minimises Σ |W s − y|² + λ tr(W Σ Wᵀ) over the mean responses s of
the patches, where Σ is the covariance of the noise of single samples, and λ is the one of eight that gives the lowest ΔE2000. It thus knows what L³ does not, and is a bound for any
linear colour correction. Both are scored twice: by the mean colour of each patch, and by the colours of its single pixels. A pixel of the matrix has a sample of every channel, as
if nothing had to be interpolated.
"""

import argparse

import numpy as np
import smalti

ROWS, COLS = 4, 6
# The part of a patch that is scored, from its edges.
INNER = 0.3
WHITE_PATCH = 18
WEIGHTS = [0.0, *(4.0 ** np.arange(-3, 4))]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cameras", nargs="*", default=["bayer", "rgbw", "rgbcmy"], help="cameras with a mosaic (default bayer rgbw rgbcmy)")
    parser.add_argument("--luminance", default="0.3,1,3,10,30,80", help="mean luminances of the chart, cd/m² (default 0.3,1,3,10,30,80)")
    parser.add_argument("--seed", default=1, type=int, help="seed of the noise (default 1)")
    return parser.parse_args()


def inner(rows: int, cols: int):
    """The rows and columns of the inner part of every patch, row by row."""
    for i in range(ROWS):
        for j in range(COLS):
            low, high = (i + INNER, j + INNER), (i + 1 - INNER, j + 1 - INNER)
            yield slice(int(rows * low[0] / ROWS), int(rows * high[0] / ROWS)), slice(int(cols * low[1] / COLS), int(cols * high[1] / COLS))


def samples(raw: smalti.RawImage, places: list) -> list[list[np.ndarray]]:
    """The normalised samples of each channel in each patch."""
    values, tile = raw.normalized(), np.asarray(raw.tile)
    channels = np.tile(tile, -(-np.array(values.shape) // tile.shape))[: values.shape[0], : values.shape[1]]
    return [[values[place][channels[place] == c] for c in range(tile.max() + 1)] for place in places]


def errors(colours: np.ndarray, targets: np.ndarray, white: np.ndarray) -> np.ndarray:
    """ΔE2000 of colours, patch × (pixel ×) XYZ, from those of the patches."""
    targets = targets.reshape(len(targets), *[1] * (colours.ndim - 2), 3)
    labs = [smalti.lab_from_xyz(c, white) for c in (colours, np.broadcast_to(targets, colours.shape))]
    return smalti.delta_e(*labs)


def main():
    options = arguments()
    print("| camera | cd/m² | mean colours: L³ · matrix | largest: L³ · matrix | single pixels: L³ · matrix |")
    print("| --- | --- | --- | --- | --- |")
    for name in options.cameras:
        camera = smalti.Camera(name)
        pipeline = smalti.train(camera, illuminants=["D65"], quality="best", progress=False)
        chart = camera.fitted(smalti.Scene("macbeth"))
        for luminance in map(float, options.luminance.split(",")):
            scene = chart.replaced(luminance_cd_m2=luminance)
            taken = camera.photograph(scene, pipeline=pipeline, seed=options.seed)
            clean = camera.photograph(scene, pipeline=pipeline, noise="none")
            places = list(inner(*taken.raw.shape[:2]))
            noisy = samples(taken.raw, places)
            means = np.array([[channel.mean() for channel in patch] for patch in samples(clean.raw, places)])
            reference, picture = np.asarray(taken.reference()), np.asarray(taken.picture)
            targets = np.array([reference[place].mean((0, 1)) for place in places])
            white = targets[WHITE_PATCH]
            least = min(len(channel) for patch in noisy for channel in patch)
            of_patches = [picture[place].reshape(-1, 3) for place in places]
            learned = [np.array([p.mean(0) for p in of_patches]), np.array([p[:: len(p) // least][:least] for p in of_patches])]
            single = np.array([[channel[:least] for channel in patch] for patch in noisy]).swapaxes(1, 2)
            noise = np.diag(((single - means[:, None]) ** 2).mean((0, 1)))
            matrices = [
                np.linalg.solve(means.T @ means + weight * len(means) * noise, means.T @ targets) for weight in WEIGHTS
            ]
            own = [errors(colours, targets, white) for colours in learned]
            rivals = [min((errors(m @ matrix, targets, white) for matrix in matrices), key=np.mean) for m in (means, single)]
            print(
                f"| {name} | {luminance:g} | {own[0].mean():.2f} · {rivals[0].mean():.2f} | "
                f"{own[0].max():.1f} · {rivals[0].max():.1f} | {own[1].mean():.2f} · {rivals[1].mean():.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
