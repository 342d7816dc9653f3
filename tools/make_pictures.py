#!/usr/bin/env python3
"""Makes the pictures of the documentation, docs/images/*.png, with a built `smalti`.

    cargo build --release -p smalti-cli
    python3 tools/make_pictures.py target/release/smalti

Needs numpy and Pillow 10.1 or newer (its scalable default font). The cameras and scenes are built in, the seeds
fixed: the pictures come out the same each time, up to the versions of Pillow and its font.
"""

import colorsys
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image, ImageDraw, ImageFont

OUT = pathlib.Path(__file__).resolve().parent.parent / "docs/images"
PAPER, INK, FAINT = (255, 255, 255), (30, 30, 30), (110, 110, 110)

# What a letter of a pattern looks like, linear RGB 0–1.
FILTERS = {
    "R": (1, 0.05, 0.03), "G": (0.04, 0.75, 0.08), "B": (0.03, 0.1, 1), "W": (1, 1, 1), "C": (0.1, 0.8, 0.9),
    "Y": (1, 0.85, 0.05), "M": (0.85, 0.1, 0.7), "E": (0.02, 0.6, 0.4), "I": (0.16, 0.05, 0.06), "O": (1, 0.35, 0.02),
    "X": (0.05, 0.45, 0.02),
}
# Where a letter means something else: `clear`, not cyan.
CLEAR = {"rccb", "rccc"}
# Carrier phases of the arrays whose cells are mixtures, as in the catalogue: mean, amplitude, turns per primary.
MIXTURES = {
    "hirakawa2008": [(0.5, 8**-0.5, -0.125), (0.5, 0.5, 0.5), (0.5, 8**-0.5, 0.125)],
    "condat2011": [(0.5, 3**-0.5, t - 0.25) for t in (0, 1 / 3, -1 / 3)],
}


def smalti(*args):
    done = subprocess.run([sys.argv[1], *map(str, args)], check=True, stdout=subprocess.PIPE)
    return done.stdout


def encoded(linear):
    """sRGB bytes of linear light."""
    v = np.clip(linear, 0, 1)
    v = np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)
    return (255 * v + 0.5).astype(np.uint8)


def font(size):
    return ImageFont.load_default(size=size)


def fitted(image, cols, rows):
    image = image.copy()
    image.thumbnail((cols, rows), Image.LANCZOS)
    return image


def save(image, name):
    OUT.mkdir(parents=True, exist_ok=True)
    image.save(OUT / name, optimize=True)
    print(f"{OUT / name}: {image.width} × {image.height}, {(OUT / name).stat().st_size / 1e3:.0f} kB")


def stages(work):
    """Scene, mosaic and picture side by side; the mosaic enlarged, its place marked in the others."""
    size, crop, zoom, gap, foot = 480, 48, 10, 18, 64
    place = (128, 350)  # column, row of the crop
    camera = ["--set", "sensor.rows=480", "--set", "sensor.cols=480"]
    smalti("simulate", "bayer", "--scene", "dead-leaves", *camera, "--stages", "-q", "-o", work / "stages")
    smalti("convert", "dead-leaves", "-q", "-o", work / "scene.png")
    scene = Image.open(work / "scene.png").convert("RGB").resize((size, size), Image.LANCZOS)
    picture = Image.open(work / "stages/rendered.png").convert("RGB")

    raw = np.load(work / "stages/3-raw.npy")[0].astype(float)
    about = json.loads((work / "stages/stages.json").read_text())["3-raw"]["numbers"]
    part = raw[place[1] : place[1] + crop, place[0] : place[0] + crop] - about["black_level"][0]
    part /= np.percentile(part, 99.5)
    tile = [[FILTERS[letter] for letter in row] for row in ("RG", "GB")]
    # The crop begins at an even row and column, so at the tile's corner.
    mosaic = np.tile(np.array(tile, float), (crop // 2, crop // 2, 1)) * part[:, :, None]
    mosaic = Image.fromarray(encoded(mosaic)).resize((crop * zoom,) * 2, Image.NEAREST)

    sheet = Image.new("RGB", (3 * size + 2 * gap, size + foot), PAPER)
    draw = ImageDraw.Draw(sheet)
    # Pillow's font knows little beyond ASCII.
    captions = [
        ("Scene", "dead leaves, spectra of natural objects"),
        ("Raw mosaic", f"{crop} by {crop} of its pixels, in the colours of their filters"),
        ("Rendered picture", "Bayer, 480 by 480 pixels, f/4, all noise"),
    ]
    for i, (image, (title, line)) in enumerate(zip((scene, mosaic, picture), captions)):
        x = i * (size + gap)
        sheet.paste(image, (x, 0))
        if i != 1:
            box = (x + place[0] - 1, place[1] - 1, x + place[0] + crop, place[1] + crop)
            draw.rectangle((box[0] - 1, box[1] - 1, box[2] + 1, box[3] + 1), outline=(0, 0, 0))
            draw.rectangle(box, outline=PAPER, width=2)
        draw.text((x, size + 8), title, fill=INK, font=font(22))
        draw.text((x, size + 37), line, fill=FAINT, font=font(17))
    save(sheet, "stages.png")


def contact_sheet(work):
    """Every built-in scene as the camera `bayer` renders it."""
    names = [entry["name"] for entry in json.loads(smalti("list", "scenes", "--json"))]
    cols, cell, rows_px, foot, gap = 5, 216, 162, 30, 12
    lines = -(-len(names) // cols)
    sheet = Image.new("RGB", (cols * (cell + gap) - gap, lines * (rows_px + foot + gap) - gap), PAPER)
    draw = ImageDraw.Draw(sheet)
    for i, name in enumerate(names):
        smalti("simulate", "bayer", "--scene", name, "-q", "-o", work / name)
        picture = fitted(Image.open(work / name / "rendered.png").convert("RGB"), cell, rows_px)
        x, y = i % cols * (cell + gap), i // cols * (rows_px + foot + gap)
        draw.rectangle((x, y, x + cell - 1, y + rows_px - 1), fill=(236, 236, 236))
        sheet.paste(picture, (x + (cell - picture.width) // 2, y + (rows_px - picture.height) // 2))
        draw.text((x, y + rows_px + 5), name, fill=INK, font=font(17))
    save(sheet, "scenes.png")


def learned(work):
    """Bayer and RGBW with learned pipelines beside what an observer sees, and the kernels of the second."""
    smalti("compare", "bayer", "rgbw", "--luminance", "1,80", "-q", "-o", work / "compare")
    rows = [("resolution-chart", 1), ("macbeth", 1), ("macbeth", 80)]
    names = [f"side-by-side/{s}-{l}-cd-m2.png" for s, l in rows] + ["rgbw-kernels.png"]
    pictures = [Image.open(work / "compare" / name).convert("RGB") for name in names]
    sheet = Image.new("RGB", (max(p.width for p in pictures), sum(p.height for p in pictures)), PAPER)
    y = 0
    for picture in pictures:
        sheet.paste(picture, (0, y))
        y += picture.height
    save(sheet.quantize(256, dither=Image.Dither.NONE), "learned.png")


def filter_color(name, letters, row, col, rows, cols):
    """Linear RGB of a cell."""
    letter = letters[row][col]
    if name in MIXTURES:
        turns = row / rows + col / cols
        return tuple(m + a * math.cos(math.tau * (turns + t)) for m, a, t in MIXTURES[name])
    if name.startswith("multispectral"):
        # Bands from violet to red.
        bands = rows * cols
        k = (ord(letter) - ord("A")) / (bands - 1)
        r, g, b = colorsys.hsv_to_rgb(0.77 * (1 - k), 0.95, 0.95)
        return r**2.2, g**2.2, b**2.2
    if letter == "C" and name in CLEAR:
        letter = "W"
    return FILTERS[letter]


def cfa_sheet():
    """The tiles of the catalogue, each repeated over a square of about 12 × 12 cells."""
    entries = json.loads(smalti("list", "cfas", "--json"))
    cols, side, cell, foot, gap = 9, 120, 134, 24, 10
    lines = -(-len(entries) // cols)
    sheet = Image.new("RGB", (cols * (cell + gap) - gap, lines * (side + foot + gap) - gap), PAPER)
    draw = ImageDraw.Draw(sheet)
    for i, entry in enumerate(entries):
        x, y = i % cols * (cell + gap), i // cols * (side + foot + gap)
        px = 10
        for r in range(side // px):
            for c in range(side // px):
                at = (entry["name"], entry["pattern"], r % entry["rows"], c % entry["cols"])
                linear = np.array(filter_color(*at, entry["rows"], entry["cols"]))
                box = (x + c * px, y + r * px, x + c * px + px - 1, y + r * px + px - 1)
                draw.rectangle(box, fill=tuple(int(v) for v in encoded(linear)), outline=(60, 60, 60))
        draw.text((x, y + side + 3), entry["name"], fill=INK, font=font(14))
    save(sheet, "cfas.png")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        stages(work)
        contact_sheet(work)
        learned(work)
    cfa_sheet()


if __name__ == "__main__":
    main()
