"""Contact sheet of the stored scenes: docs/images/natural-scenes.png."""

import importlib
import pathlib

import numpy as np
from PIL import Image

from . import codec, picture

ROOT = pathlib.Path(__file__).resolve().parents[2]


def write(names: list[str], store: pathlib.Path) -> None:
    """Three scenes a row, each averaged to 288 × 216, in 256 colours."""
    tiles = []
    for name in names:
        scene = codec.decode((store / f"{name}.spc").read_bytes())
        module = importlib.import_module(f"scenes.{name}")
        rgb = picture.srgb(scene.radiance, scene.light, getattr(module, "PERCENTILE", 99.0))
        tiles.append(np.asarray(Image.fromarray(rgb).resize((288, 216), Image.Resampling.LANCZOS)))
    rows = [np.concatenate(tiles[i : i + 3], axis=1) for i in range(0, len(tiles), 3)]
    sheet = Image.fromarray(np.concatenate(rows, axis=0)).quantize(256, Image.Quantize.MEDIANCUT, dither=Image.Dither.FLOYDSTEINBERG)
    sheet.save(ROOT / "docs/images/natural-scenes.png", optimize=True)
