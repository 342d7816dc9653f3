#!/usr/bin/env python3
"""Compares L³ with Menon 2007, Malvar 2004 and bilinear demosaicking of PyPI's colour-demosaicing on Bayer, without noise.

    cargo build --release -p smalti-cli
    python3 -m venv target/venv && target/venv/bin/pip install colour-demosaicing numpy
    target/venv/bin/python tools/compare_menon.py

The script makes all data: the raw images (`smalti simulate --noise none`), the ground truth (the same camera with three sensors
behind a prism, so that every pixel has all channels), and the learned tables (`smalti train bayer --target bayer`: camera RGB instead of
XYZ, so that L³ performs the same task as the others). One matrix, the least-squares matrix of the camera, then maps all results from camera RGB to
XYZ. L³ has no colour correction of its own. The other methods demosaic samples with balanced white. The scenes are the charts of `smalti compare` and the
photographs among its natural scenes, under D65; the path-traced scenes have lamps of their own. None is used for training. They are exposed so that the brightest pixel is at 0.8 of saturation. The script prints the CPSNR in XYZ against the truth, in dB, with the largest Y of the
truth as peak.
"""

import argparse
import json
import pathlib
import shlex
import subprocess
import tempfile
import warnings

import numpy as np

with warnings.catch_warnings():
    # The warning is about plotting, which is not used.
    warnings.simplefilter("ignore")
    from colour_demosaicing import (
        demosaicing_CFA_Bayer_bilinear,
        demosaicing_CFA_Bayer_Malvar2004,
        demosaicing_CFA_Bayer_Menon2007,
    )

ROOT = pathlib.Path(__file__).resolve().parent.parent

# The scenes of each set with the pixels they cover at two samples per pixel.
SCENES = {
    # Those of `test_scenes` in crates/smalti/src/camera/compare.rs.
    "charts": [
        ("dead-leaves?rows=576&cols=768&least=2&largest=150&seed=1001", (288, 384)),
        ("macbeth?patch=128", (256, 384)),
        ("resolution-chart?rows=576", (288, 384)),
        ("siemens-star?size=576", (288, 288)),
        ("hdr?rows=384", (192, 288)),
    ],
    "photographs": [
        ("photo-astronaut", (256, 256)),
        ("photo-brushes", (288, 384)),
        ("photo-dahlia", (213, 320)),
        ("photo-fig", (288, 384)),
        ("photo-pagoda", (213, 320)),
        ("photo-raccoon", (288, 384)),
        ("photo-spices", (240, 320)),
        ("photo-stream", (288, 384)),
    ],
}

# The training options of each L³ table.
TABLES = {
    "5x5 flat-texture": "--patch 5 --textures flat-texture",
    "5x5 oriented": "--patch 5 --textures oriented",
    "7x7 oriented": "--patch 7 --textures oriented",
    "9x9 oriented": "--patch 9 --textures oriented",
}
NOISE_FREE = {
    "sensor.pixel.read_noise_mv": "0",
    "sensor.pixel.dark_voltage_v_per_s": "0",
    "sensor.dsnu_mv": "0",
    "sensor.prnu_percent": "0",
    "sensor.adc_bits": "16",
}
BRIGHTEST = 0.8


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--smalti", default=ROOT / "target/release/smalti", type=pathlib.Path, help="the command to use")
    parser.add_argument("--scenes", choices=SCENES, default="charts", help="the set of scenes (default charts)")
    parser.add_argument("--border", default=8, type=int, help="pixels left out at every edge (default 8)")
    parser.add_argument("--work", type=pathlib.Path, help="keep tables and images in this folder, and use what is there")
    parser.add_argument(
        "--l3",
        action="append",
        metavar="OPTIONS",
        help="train L³ with these options of `smalti train`; may be given more than once (default: several)",
    )
    parser.add_argument("--illuminants", default="D65", help="lights of the training set (default D65, that of the scenes)")
    parser.add_argument("--solver", default="wiener", help="solver of L³ (default wiener)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="key of the camera, in training")
    parser.add_argument("--json", action="store_true", help="print JSON")
    return parser.parse_args()


def smalti(args, *words):
    command = [str(args.smalti), *map(str, words), "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{shlex.join(command)}\n{done.stderr}")


def keys(settings):
    return [w for key, value in settings.items() for w in ("--set", f"{key}={value}")]


def simulate(args, spec, size, luminance, folder, **other):
    settings = {**NOISE_FREE, "sensor.rows": size[0], "sensor.cols": size[1], **other}
    if not (folder / "metrics.json").is_file():
        words = ["--scene", spec, "--luminance", luminance, "--noise", "none", "--stages", "-o", folder]
        smalti(args, "simulate", "bayer", *words, *keys(settings))
    levels = json.loads((folder / "stages.json").read_text())["3-raw"]["numbers"]
    raw = np.load(folder / "3-raw.npy").astype(np.float64)
    black, white = (levels[k][0] for k in ("black_level", "white_level"))
    return (raw - black) / (white - black), np.load(folder / "4-picture-xyz.npy").astype(np.float64)


def cpsnr(of, truth, border):
    cut = (slice(None), slice(border, -border), slice(border, -border))
    return 10 * np.log10(truth[1].max() ** 2 / np.mean((of[cut] - truth[cut]) ** 2))


def main():
    args = arguments()
    with tempfile.TemporaryDirectory() as temporary:
        work = args.work or pathlib.Path(temporary)
        work.mkdir(parents=True, exist_ok=True)
        results = measure(args, work)
    names = list(results)
    if args.json:
        print(json.dumps(results, indent=2))
        return
    print(f"{'':28}" + "".join(f"{spec.split('?')[0]:>18}" for spec, _ in SCENES[args.scenes]) + f"{'mean':>9}")
    for name in names:
        values = list(results[name].values())
        print(f"{name:28}" + "".join(f"{v:18.2f}" for v in values) + f"{np.mean(values):9.2f}")


def measure(args, work):
    tables = {}
    chosen = {o: o for o in args.l3} if args.l3 else TABLES
    # A table applies to the black and white levels of its raw files only.
    training = {"sensor.adc_bits": "16", **dict(s.split("=", 1) for s in args.set)}
    for number, (name, options) in enumerate(chosen.items()):
        table = work / f"{number}.l3"
        words = ["--target", "bayer", "--solver", args.solver, "--illuminants", args.illuminants, *shlex.split(options)]
        smalti(args, "train", "bayer", *words, *keys(training), "-o", table)
        tables[f"L3 {name}"] = table
    classic = {
        "bilinear": demosaicing_CFA_Bayer_bilinear,
        "Malvar 2004": demosaicing_CFA_Bayer_Malvar2004,
        "Menon 2007": demosaicing_CFA_Bayer_Menon2007,
    }
    results = {name: {} for name in [*classic, *tables]}
    # The methods of Malvar and Menon assume that detail is equal in all channels, so that they follow white balance, as in raw converters.
    white, _ = simulate(args, "uniform", (64, 64), 1000, work / "white", **{"sensor.architecture": "prism"})
    gains = white.mean((1, 2)).max() / white.mean((1, 2))
    for number, (spec, size) in enumerate(SCENES[args.scenes]):
        # The brightest pixel of the truth determines the luminance that brings it to the wanted level.
        dim, _ = simulate(args, spec, size, 1, work / f"{args.scenes}-{number}-dim", **{"sensor.architecture": "prism"})
        light = round(BRIGHTEST / dim.max(), 4)
        rgb, xyz = simulate(args, spec, size, light, work / f"{args.scenes}-{number}-truth", **{"sensor.architecture": "prism"})
        folder = work / f"{args.scenes}-{number}-raw"
        raw, _ = simulate(args, spec, size, light, folder)
        # The picture behind the prism is camera RGB times the matrix of the camera, so that least squares recover this matrix.
        pixels = rgb.reshape(3, -1)
        matrix = np.linalg.lstsq(pixels.T, xyz.reshape(3, -1).T, rcond=None)[0].T
        def to_xyz(image):
            return np.einsum("ij,jrc->irc", matrix, image)
        truth = to_xyz(rgb)
        _, rows, cols = raw.shape
        balance = np.tile(gains[[[0, 1], [1, 2]]], (rows // 2 + 1, cols // 2 + 1))[:rows, :cols]
        for name, method in classic.items():
            image = np.moveaxis(np.asarray(method(raw[0] * balance, "RGGB")), 2, 0) / gains[:, None, None]
            results[name][spec] = cpsnr(to_xyz(image), truth, args.border)
        for name, table in tables.items():
            smalti(args, "render", folder / "raw.dng", "--pipeline", table, "-o", work / "l3.npy")
            image = np.load(work / "l3.npy").astype(np.float64)
            results[name][spec] = cpsnr(to_xyz(image), truth, args.border)
            # The scale must be 1 for all channels and scenes. It is checked and not fitted.
            scale = (image * rgb).sum() / (rgb * rgb).sum()
            if abs(scale - 1) > 0.05:
                raise SystemExit(f"{name} is on a scale of its own: {scale:.3f}")
    return results


if __name__ == "__main__":
    main()
