#!/usr/bin/env python3
"""Compares L³ with raw developers and with published methods on noisy raw files, in one run: quality and speed.

    apt-get install --no-install-recommends rawtherapee darktable
    python3 -m venv target/rivals && target/rivals/bin/pip install . tifffile opencv-python-headless colour-demosaicing
    target/rivals/bin/python tools/compare_developers.py                  # quality on Bayer, then speed
    target/rivals/bin/python tools/compare_developers.py --mosaic xtrans

The rivals are RawTherapee (RCD and AMaZE, or for X-Trans its three-pass method, each also with its denoiser), darktable (its default
demosaicking), Menon 2007 (colour-demosaicing) and bilinear demosaicking with non-local means (OpenCV), beside the classic methods of Smalti.
All develop the same DNG files of the camera `bayer` with white balance and without any tone curve, sharpening or profile, and give camera RGB.

One 3 × 3 matrix per method maps camera RGB to XYZ: least squares on a ColorChecker without noise, developed by the same method. L³ has no
matrix. A denoiser is run at several strengths, and the strength with the best mean CPSNR at a luminance is taken, which is in favour of
the rival. Four pixels are cut at every edge, which RawTherapee leaves out of Bayer (seven of X-Trans). Scores are those of `smalti.score_picture`.

The speed is that of the whole command, from a DNG of 12 megapixels to a TIFF of 16 bits, less the time that the same command takes for a tiny
DNG, on all cores.
"""

import argparse
import json
import pathlib
import shutil
import subprocess
import tempfile
import time

import cv2
import numpy as np
import smalti
import tifffile
from compare_menon import SCENES
from colour_demosaicing import demosaicing_CFA_Bayer_bilinear, demosaicing_CFA_Bayer_Menon2007

# Strengths of the denoisers: luminance of RawTherapee, 0 to 100, and h of non-local means relative to the noise of 8-bit values.
DENOISE = (20, 50, 80)
NON_LOCAL = (0.4, 0.8, 1.2)
CUT = 4
# Some runs of darktable 4.2 develop a file of no known camera with another brightness: of several runs, the best of each scene counts.
DARKTABLE_RUNS = 3
# Rows and columns of the frame whose development is timed: 12 megapixels.
SIZE = (3000, 4000)
PROFILE = """[Version]
AppVersion=5.9
Version=349
[Exposure]
Auto=false
Compensation=0
HistogramMatching=false
[White Balance]
Enabled=true
Setting=Camera
[Color Management]
InputProfile=(none)
WorkingProfile=sRGB
OutputProfile=RTv4_sRGB
OutputBPC=false
[RAW Bayer]
Method={method}
Border=4
[RAW X-Trans]
Method={method}
[Sharpening]
Enabled=false
[Directional Pyramid Denoising]
Enabled={denoise}
Luma={strength}
LMethod=SLI
CMethod=AUT
C2Method=AUTO
"""


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")


def linear(values):
    """sRGB to linear light."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def encoded(values):
    values = np.clip(values, 0, 1)
    return np.where(values <= 0.0031308, 12.92 * values, 1.055 * values ** (1 / 2.4) - 0.055)


class RawTherapee:
    def __init__(self, work, method, strength=None):
        self.profile = work / f"{method}-{strength}.pp3"
        self.profile.write_text(
            PROFILE.format(method=method, denoise=str(strength is not None).lower(), strength=strength or 0)
        )

    def command(self, dng, tif):
        return ["rawtherapee-cli", "-Y", "-b16", "-t", "-p", self.profile, "-o", tif, "-c", dng]

    def develop(self, photo, dng, work):
        run(*self.command(dng, work / "rt.tif"))
        return linear(tifffile.imread(work / "rt.tif") / 65535.0)


class Darktable:
    def __init__(self, work):
        self.folder = work / "darktable"

    def command(self, dng, tif, bits=16):
        # Nothing that it remembers of other pictures.
        shutil.rmtree(self.folder, ignore_errors=True)
        options = {
            "plugins/darkroom/workflow": "none",
            "plugins/darkroom/chromatic-adaptation": "legacy",
            "plugins/imageio/format/tiff/bpp": bits,
            "write_sidecar_files": "never",
        }
        conf = [w for key, value in options.items() for w in ("--conf", f"{key}={value}")]
        core = ["--core", "--library", ":memory:", "--configdir", self.folder, "--cachedir", self.folder, *conf]
        return ["darktable-cli", dng, tif, "--icc-type", "LIN_REC709", *core]

    def develop(self, photo, dng, work):
        tif = work / "dt.tif"
        tif.unlink(missing_ok=True)
        run(*self.command(dng, tif, 32))
        return cut(tifffile.imread(tif).astype(np.float64))


class Demosaic:
    """A method that demosaics samples with balanced white; non-local means follow, if a strength is given."""

    def __init__(self, method, gains, strength=None):
        self.method, self.gains, self.strength = method, gains, strength

    def develop(self, photo, dng, work):
        samples = np.asarray(photo.raw.normalized(), dtype=np.float64)
        rows, cols = samples.shape
        balance = np.tile(self.gains[[[0, 1], [1, 2]]], (rows // 2 + 1, cols // 2 + 1))[:rows, :cols]
        image = np.asarray(self.method(samples * balance, "RGGB"))
        if self.strength:
            # Exposed to the range of eight bits, as a developer shows it.
            scale = np.quantile(image, 0.995)
            shown = np.uint8(np.round(255 * encoded(image / scale)))
            noise = np.median(np.abs(np.diff(shown.astype(np.float64), axis=1))) / 0.954
            h = float(max(self.strength * noise, 1.0))
            image = linear(cv2.fastNlMeansDenoisingColored(shown, None, h, h, 7, 21) / 255.0) * scale
        return cut(image)


class Smalti:
    """A classic method of Smalti, or L³."""

    def __init__(self, camera, pipeline=None):
        self.camera, self.pipeline = camera, pipeline

    def develop(self, photo, dng, work):
        picture = self.pipeline.render(photo.raw) if self.pipeline else self.camera.render(photo.raw, "D65")
        return cut(np.asarray(picture.array, dtype=np.float64))


def cut(image):
    return image[CUT:-CUT, CUT:-CUT]


def beneath(image, reference):
    """The part of a reference that a picture without some of its edges shows."""
    rows, cols = image.shape[:2]
    top, left = (reference.shape[0] - rows) // 2, (reference.shape[1] - cols) // 2
    return reference[top : top + rows, left : left + cols]


def methods(args, camera, pipelines, work):
    """Each method with the strengths to choose from."""
    classic = {}
    if args.mosaic == "bayer":
        white = smalti.Scene("uniform", luminance_cd_m2=80.0)
        flat = camera.photograph(white, noise="none").raw
        samples = np.asarray(flat.normalized(), dtype=np.float64)
        cells = [samples[0::2, 0::2], (samples[0::2, 1::2] + samples[1::2, 0::2]) / 2, samples[1::2, 1::2]]
        means = np.array([np.mean(c) for c in cells])
        gains = means.max() / means
        for name in ("bilinear", "malvar2004", "hamilton-adams1997"):
            classic[name] = [Smalti(smalti.Camera("bayer", set={"isp.demosaic": name}))]
        classic["Menon 2007"] = [Demosaic(demosaicing_CFA_Bayer_Menon2007, gains)]
        classic["bilinear + NLM"] = [Demosaic(demosaicing_CFA_Bayer_bilinear, gains, s) for s in NON_LOCAL]
        developers = {"RCD": "rcd", "AMaZE": "amaze"}
    else:
        classic["bilinear"] = [Smalti(camera)]
        developers = {"three passes": "3-pass (best)"}
    for name, method in developers.items():
        classic[f"RawTherapee {name}"] = [RawTherapee(work, method)]
        classic[f"RawTherapee {name}, denoised"] = [RawTherapee(work, method, s) for s in DENOISE]
    classic["darktable"] = [Darktable(work)] * DARKTABLE_RUNS
    learned = {f"L³ {name}": [Smalti(camera, pipeline)] for name, pipeline in pipelines.items()}

    def wanted(all_):
        return {name: m for name, m in all_.items() if not args.methods or any(text in name for text in args.methods)}

    return wanted(classic), wanted(learned)


def matrix(method, checker, dng, work):
    """Camera RGB to XYZ, by least squares on a ColorChecker without noise."""
    image = method.develop(checker, dng, work)
    truth = beneath(image, np.asarray(checker.reference().array))
    return np.linalg.lstsq(image.reshape(-1, 3), truth.reshape(-1, 3), rcond=None)[0]


def quality(args, camera, pipelines, work):
    classic, learned = methods(args, camera, pipelines, work)
    checker = camera.photograph(smalti.Scene("macbeth", luminance_cd_m2=80.0), noise="none")
    checker_dng = work / "checker.dng"
    checker.raw.write(checker_dng)
    choices = {name: [(m, matrix(m, checker, checker_dng, work)) for m in all_] for name, all_ in classic.items()}
    choices |= {name: [(m, np.eye(3)) for m in all_] for name, all_ in learned.items()}
    rows = []
    for luminance in args.luminance:
        found = {name: [[] for _ in all_] for name, all_ in choices.items()}
        for spec, _ in SCENES[args.scenes]:
            photo = camera.photograph(smalti.Scene(spec, luminance_cd_m2=luminance), seed=args.seed)
            photo.raw.write(work / "scene.dng")
            reference = photo.reference()
            for name, all_ in choices.items():
                for place, (method, to_xyz) in enumerate(all_):
                    image = method.develop(photo, work / "scene.dng", work) @ to_xyz
                    picture = smalti.Image(image.astype(np.float32), "xyz", reference.white)
                    truth = smalti.Image(beneath(image, np.asarray(reference.array)), "xyz", reference.white)
                    scores = smalti.score_picture(picture, truth)
                    found[name][place].append({"scene": spec, **scores})
        for name, places in found.items():
            if name == "darktable":
                places = [[max(runs, key=lambda s: s["cpsnr_db"]) for runs in zip(*places)]]
            best = max(places, key=lambda p: np.mean([s["cpsnr_db"] for s in p]))
            rows.append({"luminance_cd_m2": luminance, "method": name, "place": places.index(best), "scenes": best})
    return rows


def speed(pipelines, work):
    """Megapixels per second of whole commands, from a large DNG to a TIFF."""
    for name, pipeline in pipelines.items():
        pipeline.write(work / f"{name}.l3")
    for name, (height, width) in {"large": SIZE, "tiny": (256, 256)}.items():
        sized = smalti.Camera("bayer", set={"sensor.rows": height, "sensor.cols": width})
        photo = sized.photograph(smalti.Scene("photo-stream", luminance_cd_m2=80.0), full_frame=True)
        photo.raw.write(work / f"{name}.dng")
    commands = {
        "L³ fast": lambda dng, tif: ["smalti", "render", dng, "--pipeline", work / "fast.l3", "-o", tif],
        "L³ best": lambda dng, tif: ["smalti", "render", dng, "--pipeline", work / "best.l3", "-o", tif],
        "RawTherapee RCD": RawTherapee(work, "rcd").command,
        "RawTherapee AMaZE": RawTherapee(work, "amaze").command,
        "darktable": Darktable(work).command,
    }
    rows = []
    for name, of in commands.items():
        seconds = {}
        for size in ("tiny", "large"):
            runs = []
            for _ in range(3):
                (work / "speed.tif").unlink(missing_ok=True)
                start = time.perf_counter()
                run(*of(work / f"{size}.dng", work / "speed.tif"))
                runs.append(time.perf_counter() - start)
            seconds[size] = min(runs)
        rate = SIZE[0] * SIZE[1] / 1e6 / (seconds["large"] - seconds["tiny"])
        rows.append({"method": name, "seconds": seconds["large"], "megapixels_per_s": rate})
    return rows


def show(rows):
    names = [s["scene"].split("?")[0] for s in rows[0]["scenes"]]
    print("| cd/m² | method | " + " | ".join(names) + " | CPSNR, dB | ΔE2000 | S-CIELAB |")
    print("| --- " * (len(names) + 5) + "|")
    for row in rows:
        each = " | ".join(f"{s['cpsnr_db']:.2f}" for s in row["scenes"])
        metrics = ("cpsnr_db", "pixel_delta_e_2000_mean", "scielab_mean")
        means = " | ".join(f"{np.mean([s[metric] for s in row['scenes']]):.2f}" for metric in metrics)
        print(f"| {row['luminance_cd_m2']:g} | {row['method']} | {each} | {means} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mosaic", choices=("bayer", "xtrans"), default="bayer", help="the mosaic (default bayer)")
    parser.add_argument("--scenes", choices=SCENES, default="photographs", help="the set of scenes (default photographs)")
    parser.add_argument("--luminance", type=float, nargs="+", default=[1.0, 10.0, 80.0], help="cd/m² (default 1 10 80)")
    parser.add_argument("--methods", nargs="+", metavar="TEXT", help="only methods whose names contain one of these (default all)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the noise (default 1)")
    parser.add_argument("--only", choices=("quality", "speed"), help="measure one of them")
    parser.add_argument("--json", type=pathlib.Path, help="write all scores to this file")
    args = parser.parse_args()
    tile = {"sensor.cfa.pattern": "xtrans"} if args.mosaic == "xtrans" else {}
    camera = smalti.Camera("bayer", set=tile)
    pipelines = {
        quality: smalti.train(camera, illuminants=["D65"], quality=quality, progress=False) for quality in ("fast", "best")
    }
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        rows = [] if args.only == "speed" else quality(args, camera, pipelines, work)
        if rows:
            show(rows)
        times = [] if args.only == "quality" or args.mosaic != "bayer" else speed(pipelines, work)
        for row in times:
            print(f"| {row['method']} | {row['seconds']:.2f} s | {row['megapixels_per_s']:.1f} MP/s |")
    if args.json:
        args.json.write_text(json.dumps({"quality": rows, "speed": times}, indent=2))


if __name__ == "__main__":
    main()
