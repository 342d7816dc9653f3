"""Writes DNG files with tifffile, their samples coded by imagecodecs, into a folder; prints what they hold as JSON."""

import json
import sys
from pathlib import Path

import imagecodecs
import numpy as np
import tifffile

ROWS, COLS = 64, 96
folder = Path(sys.argv[1])

DNG = [
    (50706, "B", 4, bytes([1, 4, 0, 0]), True),
    (50707, "B", 4, bytes([1, 1, 0, 0]), True),
    (33421, "H", 2, (2, 2), True),
    (33422, "B", 4, bytes([1, 0, 2, 1]), True),
    (50714, "H", 1, 64, True),
]


def coded(tile, bits, compression):
    if compression == 7:
        return imagecodecs.ljpeg_encode(tile, bitspersample=bits)
    if compression == 52546:
        return imagecodecs.jpegxl_encode(tile, lossless=True, bitspersample=bits)
    return imagecodecs.zlib_encode(imagecodecs.delta_encode(tile, axis=-1).tobytes())


# As Adobe writes JPEG XL: the four colours of the tile in quarters of the image.
FACTORS = [(50975, "H", 1, 2, True), (52547, "H", 1, 2, True)]

for bits, compression, tile in [
    (12, 7, None),
    (16, 7, (32, 48)),
    (14, 7, (32, 48)),
    (16, 8, (32, 48)),
    (16, 52546, (32, 48)),
    (12, 52546, None),
]:
    samples = (np.arange(ROWS * COLS, dtype=np.uint64) * 2654435761 // 65536 % (1 << bits)).astype(np.uint16)
    # Half of it smooth: short codes as well as long ones.
    image = samples.reshape(ROWS, COLS)
    image[: ROWS // 2] = (np.add.outer(np.arange(ROWS // 2), np.arange(COLS)) * 3 + 64).astype(np.uint16)
    rows, cols = tile or (ROWS, COLS)
    apart = compression == 52546 and tile is not None
    stored = np.block([[image[r::2, c::2] for c in (0, 1)] for r in (0, 1)]) if apart else image
    tiles = [
        coded(np.ascontiguousarray(stored[r : r + rows, c : c + cols]), bits, compression)
        for r in range(0, ROWS, rows)
        for c in range(0, COLS, cols)
    ]
    name = f"{bits}-{compression}-{'tiles' if tile else 'strip'}.dng"
    layout = {"tile": tile} if tile else {"rowsperstrip": ROWS}
    with tifffile.TiffWriter(folder / name) as out:
        out.write(
            iter(tiles),
            shape=(ROWS, COLS),
            dtype=np.uint16,
            bitspersample=bits,
            photometric=32803,
            compression=compression,
            predictor=2 if compression == 8 else None,
            extratags=DNG + FACTORS if apart else DNG,
            metadata=None,
            **layout,
        )
    print(json.dumps({"file": name, "samples": image.ravel().tolist()}))
