"""python -m scenes photos SMALTI: errors and dimensions of the repainted photographs, and docs/images/photo-scenes.png.

Uses the command of Smalti, so that what is measured is what cameras see. Needs colour-science.
"""

import pathlib
import subprocess
import tempfile

import colour
import numpy as np
import scipy.spatial
from PIL import Image

from . import picture, spectra

ROOT = pathlib.Path(__file__).resolve().parents[2]
STORE = ROOT / "crates/smalti-io/scenes"
BANDS_NM = np.arange(400.0, 701.0, 10.0)
NAMES = ["astronaut", "brushes", "dahlia", "fig", "pagoda", "raccoon", "spices", "stream"]


def light(name: str) -> np.ndarray:
    """Spectral power in the bands."""
    s = colour.SDS_ILLUMINANTS[name]
    return np.interp(BANDS_NM, s.wavelengths, s.values)


def xyz(reflectance: np.ndarray, power: np.ndarray) -> np.ndarray:
    """XYZ of reflectances under a light, Y of white is 1."""
    cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    weights = np.array([np.interp(BANDS_NM, cmfs.wavelengths, cmfs.values[:, c]) for c in range(3)]).T * power[:, None]
    return reflectance @ (weights / weights[:, 1].sum())


def difference(a: np.ndarray, b: np.ndarray, power: np.ndarray) -> np.ndarray:
    """ΔE2000 of two sets of XYZ under a light."""
    white = colour.XYZ_to_xy(xyz(np.ones((1, 31)), power)[0])
    return colour.delta_E(colour.XYZ_to_Lab(a, white), colour.XYZ_to_Lab(b, white), method="CIE 2000")


def cube(smalti: str, source: list[str], folder: pathlib.Path) -> np.ndarray:
    """Reflectances of a scene in daylight, up to a factor: rows × cols × bands."""
    out = folder / "scene.npz"
    subprocess.run([smalti, "convert", *source, "--illuminant", "E", "-o", str(out)], check=True, capture_output=True)
    data = np.load(out)
    key = max(data.files, key=lambda k: data[k].size)
    values = np.asarray(data[key], np.float64)
    if values.shape[0] == 31:
        values = np.moveaxis(values, 0, -1)
    # Photons under an equal-energy light rise with wavelength.
    return values / BANDS_NM


def dimensions(reflectance: np.ndarray) -> int:
    """Principal components of the shapes, reflectances of mean 1, that hold 99.9 % of their variance."""
    shape = reflectance / reflectance.mean(axis=1, keepdims=True)
    values = np.linalg.eigvalsh(np.cov(shape.T))[::-1]
    return int(np.searchsorted(np.cumsum(values) / values.sum(), 0.999) + 1)


def metamerism(reflectance: np.ndarray) -> float:
    """95th percentile of ΔE2000 under an LED of three narrow bands between pixels of one colour in daylight: each of
    20,000 random pixels and the nearest other one in CIELAB, where they differ by less than 0.5."""
    daylight, led = light("D65"), light("LED-RGB1")
    some = reflectance[np.random.default_rng(1).choice(len(reflectance), 20_000, replace=False)]
    lab = colour.XYZ_to_Lab(xyz(some, daylight), colour.XYZ_to_xy(xyz(np.ones((1, 31)), daylight)[0]))
    distance, nearest = scipy.spatial.KDTree(lab).query(lab, k=2)
    near = distance[:, 1] < 0.5
    seen = xyz(some, led)
    return float(np.percentile(difference(seen[near], seen[nearest[near, 1]], led), 95))


def main(smalti: str) -> None:
    """Prints the table of the README and writes the sheet."""
    daylight = light("D65")
    tiles = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for photo in NAMES:
            file = STORE / f"photo-{photo}.jpg"
            rgb = colour.cctf_decoding(np.asarray(Image.open(file).convert("RGB")) / 255.0, function="sRGB")
            truth = colour.RGB_to_XYZ(rgb, "sRGB").reshape(-1, 3)
            painted = cube(smalti, [str(file), "--upsampling", "measured"], folder)
            lifted = cube(smalti, [str(file), "--upsampling", "smooth"], folder)
            flat = []
            for values in (painted, lifted):
                v = values.reshape(-1, 31)
                # Scenes are scaled to a mean luminance; reflectances have that of the photograph.
                flat.append(v * (truth[:, 1].mean() / xyz(v, daylight)[:, 1].mean()))
            error = difference(xyz(flat[0], daylight), truth, daylight)
            row = [np.median(error), np.percentile(error, 95), dimensions(flat[1]), dimensions(flat[0]), metamerism(flat[1]), metamerism(flat[0])]
            print(f"| `photo-{photo}` | {row[0]:.3f} | {row[1]:.3f} | {row[2]} | {row[3]} | {row[4]:.2f} | {row[5]:.2f} |", flush=True)
            shown = picture.srgb((painted * daylight).astype(np.float32), daylight, 99.5)
            tile = Image.fromarray(shown)
            tile.thumbnail((216, 162), Image.Resampling.LANCZOS)
            framed = Image.new("RGB", (216, 162), (255, 255, 255))
            framed.paste(tile, ((216 - tile.width) // 2, (162 - tile.height) // 2))
            tiles.append(np.asarray(framed))
    surfaces = np.array(list(spectra.reflectances().values()))
    print(f"| measured reflectances | | | | {dimensions(surfaces)} | | |")
    rows = [np.concatenate(tiles[i : i + 4], axis=1) for i in range(0, len(tiles), 4)]
    sheet = Image.fromarray(np.concatenate(rows, axis=0)).quantize(256, Image.Quantize.MEDIANCUT, dither=Image.Dither.FLOYDSTEINBERG)
    sheet.save(ROOT / "docs/images/photo-scenes.png", optimize=True)
