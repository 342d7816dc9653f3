"""Raw files of camera makers, read by LibRaw."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from ._smalti import RawImage, SmaltiError


def read_camera_raw(source: str | os.PathLike[str] | Any) -> RawImage:
    """Reads a raw file in the format of a camera maker (NEF, CR3, ARW, RAF, …) with LibRaw.

    The raw image contains the unprocessed samples of the visible area. Where the black levels of channels differ, samples are shifted to
    the highest level. The two greens of a Bayer mosaic are one channel. `RawImage.read` reads DNG files without LibRaw.

    Args:
        source: a file, or an open `rawpy.RawPy`.

    Raises:
        ImportError: without rawpy (`pip install smalti[raws]`).
        OSError: when the file cannot be opened.
        SmaltiError: when the file has no mosaic, or LibRaw cannot read it.
    """
    import rawpy

    if isinstance(source, str | os.PathLike):
        # Raises the OSError of the operating system.
        open(source, "rb").close()
        try:
            raw = rawpy.imread(os.fspath(source))
        except rawpy.LibRawError as e:
            raise SmaltiError(f"{os.fspath(source)}: LibRaw cannot read it: {e}") from e
        with raw:
            return read_camera_raw(raw)
    if source.raw_pattern is None:
        raise SmaltiError("the raw file has no mosaic: every pixel has all colours")
    letters = source.color_desc.decode()
    rows, cols = source.raw_pattern.shape
    # The tile begins at the corner of the visible area, which may differ from that of the sensor.
    cells = source.raw_colors_visible[:rows, :cols]
    seen = {letters[c] for c in np.unique(cells)}
    names = [letter for letter in dict.fromkeys(letters) if letter in seen]
    tile = np.array([names.index(letter) if letter in seen else 0 for letter in letters], np.uint8)[cells]
    black = np.array(source.black_level_per_channel, np.int64)[: len(letters)]
    highest = int(black[np.unique(cells)].max())
    samples = source.raw_image_visible.astype(np.int64) + (highest - black)[source.raw_colors_visible]
    return RawImage(
        np.clip(samples, 0, 65535).astype(np.uint16), tile, black_level=highest, white_level=source.white_level, channel_names=names
    )  # fmt: skip
