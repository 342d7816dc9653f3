#!/usr/bin/env python3
"""Makes the pictures of the documentation, docs/images/*, with a built `smalti`. `just pictures` makes all of them.

    cargo build --release -p smalti-cli
    (cd tools/page && npm ci)
    python3 tools/make_pictures.py target/release/smalti [NAME ...]

NAME is a function below; without a NAME all pictures are made. The script needs numpy, Pillow 10.1 or newer (for its scalable default font), and for
the pictures of pages Node.js and Chromium. Cameras and scenes are built in or part of the tutorial, and seeds are fixed. The pictures are therefore
reproducible, up to the versions of Pillow, its font and the browser.
"""

import colorsys
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image, ImageDraw, ImageFont

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "docs/images"
PAPER, INK, FAINT = (255, 255, 255), (30, 30, 30), (110, 110, 110)

# The colour of each letter of a pattern, linear RGB 0–1.
FILTERS = {
    "R": (1, 0.05, 0.03), "G": (0.04, 0.75, 0.08), "B": (0.03, 0.1, 1), "W": (1, 1, 1), "C": (0.1, 0.8, 0.9),
    "Y": (1, 0.85, 0.05), "M": (0.85, 0.1, 0.7), "E": (0.02, 0.6, 0.4), "I": (0.16, 0.05, 0.06), "O": (1, 0.35, 0.02),
    "X": (0.05, 0.45, 0.02),
}
# In these patterns C means clear and not cyan.
CLEAR = {"rccb", "rccc"}
# Carrier phases of the arrays of mixtures, as in the catalogue: mean, amplitude and turns for each primary.
MIXTURES = {
    "hirakawa2008": [(0.5, 8**-0.5, -0.125), (0.5, 0.5, 0.5), (0.5, 8**-0.5, 0.125)],
    "condat2011": [(0.5, 3**-0.5, t - 0.25) for t in (0, 1 / 3, -1 / 3)],
}


def smalti(*args):
    done = subprocess.run([sys.argv[1], *map(str, args)], check=True, stdout=subprocess.PIPE)
    return done.stdout


def encoded(linear):
    """Encodes linear light as sRGB bytes."""
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
    """Scene, mosaic and picture side by side. The mosaic is enlarged, and frames mark its place in the other two."""
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
    # The crop begins at an even row and column, which is the corner of the tile.
    mosaic = np.tile(np.array(tile, float), (crop // 2, crop // 2, 1)) * part[:, :, None]
    mosaic = Image.fromarray(encoded(mosaic)).resize((crop * zoom,) * 2, Image.NEAREST)

    sheet = Image.new("RGB", (3 * size + 2 * gap, size + foot), PAPER)
    draw = ImageDraw.Draw(sheet)
    # Pillow's font has few characters beyond ASCII.
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
    """The built-in charts and patterns as the camera `bayer` renders them. The stored scenes have contact sheets of their own (tools/scenes)."""
    stored = ("natural-", "photo-")
    names = [entry["name"] for entry in json.loads(smalti("list", "scenes", "--json")) if not entry["name"].startswith(stored)]
    cols, cell, rows_px, foot, gap = 4, 216, 162, 30, 12
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
    """Bayer and RGBW with learned pipelines beside the reference, and the kernels of RGBW."""
    smalti("compare", "bayer", "rgbw", "--luminance", "1,80", "--scenes", "charts", "-q", "-o", work / "compare")
    rows = [("resolution-chart", 1), ("macbeth", 1), ("macbeth", 80)]
    names = [f"side-by-side/{s}-{l}-cd-m2.png" for s, l in rows] + ["rgbw-kernels.png"]
    pictures = [Image.open(work / "compare" / name).convert("RGB") for name in names]
    sheet = Image.new("RGB", (max(p.width for p in pictures), sum(p.height for p in pictures)), PAPER)
    y = 0
    for picture in pictures:
        sheet.paste(picture, (0, y))
        y += picture.height
    save(sheet.quantize(256, dither=Image.Dither.NONE), "learned.png")


def low_light(work):
    """The first picture of the README: Bayer and RGBW at 1 cd/m², with bilinear demosaicking and with learned pipelines."""
    best = ("--processing", "l3,bilinear", "--quality", "best")
    smalti("compare", "bayer", "rgbw", *best, "--luminance", 1, "--scenes", "all", "-q", "-o", work / "dark")
    results = json.loads((work / "dark/results.json").read_text())["results"]
    scores = {(r["camera"], r["pipeline"]): r for r in results}
    # The pictures of a scene stand four to a row, the reference first, in the order of the results.
    columns = [("Reference", None), ("Bayer, bilinear", ("bayer", "bilinear")), ("Bayer, L³", ("bayer", "l3")), ("RGBW, L³", ("rgbw", "l3"))]
    # A scene, its size in the sheet, and the part of it that is shown.
    rows = [("natural-table", (384, 288), (0, 16, 384, 272)), ("resolution-chart", (384, 288), (42, 124, 192, 224))]
    head, foot, gap, size = 44, 76, 14, (300, 200)
    sheet = Image.new("RGB", (4 * size[0] + 3 * gap, head + 2 * size[1] + gap + foot), PAPER)
    draw = ImageDraw.Draw(sheet)
    bold, plain = (ImageFont.truetype(ROOT / f"crates/smalti-report/fonts/Inter-{f}.otf", s) for f, s in (("SemiBold", 27), ("Regular", 23)))
    for c, (title, key) in enumerate(columns):
        x = c * (size[0] + gap)
        place = 0 if key is None else 1 + list(scores).index(key)
        draw.text((x, 2), title, fill=INK, font=bold)
        for r, (scene, (width, height), part) in enumerate(rows):
            drawn = Image.open(work / f"dark/side-by-side/{scene}-1-cd-m2.png").convert("RGB")
            left, top = 20 + place % 4 * 404, 58 + place // 4 * (height + 68)
            box = (left + part[0], top + part[1], left + part[2], top + part[3])
            enlarged = Image.NEAREST if part[2] - part[0] < width else Image.LANCZOS
            sheet.paste(drawn.crop(box).resize(size, enlarged), (x, head + r * (size[1] + gap)))
        lines = ["A table and a part of a", "resolution chart, 1 cd/m²"]
        if key is not None:
            noise = scores[key]["targets"]["luminance_noise_percent"]["mean"]
            lines = [f"CPSNR {scores[key]['cpsnr_db']:.1f} dB", f"luminance noise {noise:.0f} %"]
        for i, line in enumerate(lines):
            draw.text((x, head + 2 * size[1] + gap + 8 + 31 * i), line, fill=INK if key else FAINT, font=plain)
    save(sheet.quantize(256, kmeans=3, dither=Image.Dither.NONE), "low-light.png")


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


def cfa_sheet(_work):
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


def row(pictures, captions, name):
    """Pictures of equal height side by side, each with a caption."""
    gap, foot = 18, 36
    sheet = Image.new("RGB", (sum(p.width for p in pictures) + gap * (len(pictures) - 1), pictures[0].height + foot), PAPER)
    draw = ImageDraw.Draw(sheet)
    x = 0
    for picture, caption in zip(pictures, captions):
        sheet.paste(picture, (x, 0))
        draw.text((x, picture.height + 8), caption, fill=INK, font=font(18))
        x += picture.width + gap
    save(sheet, name)


def opened(path, rows=480):
    """Opens a picture and scales it to a height."""
    picture = Image.open(path).convert("RGB")
    return picture.resize((picture.width * rows // picture.height, rows), Image.LANCZOS)


def tutorial(page):
    """The first TOML file of a page of the tutorial."""
    text = (ROOT / "docs/tutorial" / page).read_text()
    return re.search(r"```toml\n(.*?)```", text, re.DOTALL).group(1)


def own_camera(work):
    """The camera of the tutorial: its mosaic and its picture of the ColorChecker."""
    camera = work / "mine.toml"
    camera.write_text(tutorial("2-own-camera.md"))
    smalti("show", camera, "-o", work / "mine.png")
    smalti("simulate", camera, "--scene", "macbeth", "-q", "-o", work / "mine")
    pictures = [opened(work / "mine.png"), opened(work / "mine/rendered.png")]
    row(pictures, ["Its mosaic", "Its picture of the ColorChecker"], "own-camera.png")


def raw_file(work):
    """A raw file, rendered with classic processing and with a learned pipeline."""
    raw = work / "dim/raw.dng"
    smalti("train", "rgbw", "--illuminants", "D65", "-q", "-o", work / "rgbw.l3")
    smalti("simulate", "rgbw", "--scene", "dead-leaves", "--luminance", "2", "-q", "-o", work / "dim")
    smalti("render", raw, "--pipeline", work / "rgbw.l3", "-q", "-o", work / "learned.png")
    pictures = [opened(work / "dim/rendered.png"), opened(work / "learned.png")]
    row(pictures, ["Bilinear, and a colour matrix", "The learned pipeline, from the same raw file"], "raw-file.png")


def studies(work):
    """Figures of the studies of the documentation, and the page of one study."""
    smalti("sweep", "table2", "-q", "-o", work / "table2")
    smalti("report", work / "table2")
    figure = Image.open(work / "table2/report/panels-by-colours.png").convert("RGB")
    save(fitted(figure, 1200, 800), "studies-table2.png")
    screenshot(work / "table2/report/report.html", "report-sweep.png")
    screenshot(work / "table2/report/report.html", "report-design.png", "light", "design")
    smalti("sweep", "theory", "-q", "-o", work / "theory")
    smalti("report", work / "table2", work / "theory", "-o", work / "rules.html")
    screenshot(work / "rules.html", "report-rules-dark.png", "dark", "whole")


def learned_study(work):
    """Zone plates of learned pipelines. This study takes minutes."""
    smalti("sweep", "table2-l3", "-q", "-o", work / "learned-study")
    smalti("report", work / "learned-study")
    plates = Image.open(work / "learned-study/report/zone-plates.png").convert("RGB")
    save(plates, "studies-zone-plates.png")


def page_of_comparison(work):
    """The page of a comparison and its maps."""
    smalti("compare", "bayer", "rgbw", "-q", "-o", work / "page")
    screenshot(work / "page/report.html", "report-compare.png")
    screenshot(work / "page/report.html", "report-maps-dark.png", "dark", "ΔE2000 difference")


def studio(work):
    """The page of the studio, on a wide window and on a phone, in light and dark colours."""
    pages("studio", work)


def rate(work):
    """The page of a rating experiment: a pair and the display check, on a wide window and on a phone, in light and dark colours."""
    scenes = ["--scene", "natural-table", "--scene", "photo-fig"]
    smalti("rate", "init", "bayer", "rgbw", "--processing", "bilinear", "--luminance", "1", *scenes, "-q", "-o", work / "experiment")
    pages("rate", work, work / "experiment")


def pages(name, work, *more):
    """Screenshots by the script of a page, named after it."""
    subprocess.run(["node", ROOT / f"tools/page/{name}-pictures.mjs", sys.argv[1], work, *more], check=True)
    for made in sorted(work.glob(f"{name}*.png")):
        Image.open(made).convert("RGB").save(OUT / f"{made.stem}.webp", quality=86, method=6)
        print(f"{OUT / made.stem}.webp: {(OUT / f'{made.stem}.webp').stat().st_size / 1e3:.0f} kB")


def screenshot(page, name, *how):
    subprocess.run(["node", ROOT / "tools/page/screenshot.mjs", page, OUT / name, *how], check=True)
    print(f"{OUT / name}: {(OUT / name).stat().st_size / 1e3:.0f} kB")


PICTURES = [stages, contact_sheet, cfa_sheet, own_camera, low_light, learned, raw_file, studies, learned_study, page_of_comparison, studio, rate]


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    named = {picture.__name__: picture for picture in PICTURES}
    unknown = [name for name in sys.argv[2:] if name not in named]
    if unknown:
        sys.exit(f"no picture is called {unknown[0]}; there are {', '.join(named)}")
    for name, picture in named.items():
        if name in sys.argv[2:] or len(sys.argv) == 2:
            with tempfile.TemporaryDirectory() as work:
                picture(pathlib.Path(work))


if __name__ == "__main__":
    main()
