"""Reads DNG files with LibRaw (rawpy) and tifffile and prints what they see as JSON: one object per file."""

import json
import sys

import numpy as np
import rawpy
import tifffile

for path in sys.argv[1:]:
    with rawpy.imread(path) as raw:
        pattern = raw.raw_pattern.tolist()
        letters = raw.color_desc.decode()
        seen = {
            "samples": raw.raw_image.ravel().tolist(),
            "visible": list(raw.raw_image_visible.shape),
            "pattern": [[letters[c] for c in row] for row in pattern],
            "black": list(raw.black_level_per_channel),
            "white": int(raw.white_level),
        }
        rgb = raw.postprocess(output_bps=16, no_auto_bright=True, user_flip=0)
        seen["developed"] = list(rgb.shape)
    with tifffile.TiffFile(path) as tif:
        page = tif.pages[0]
        plain = page.compression == 1
        seen["tifffile_equal"] = plain and bool(np.array_equal(page.asarray().ravel(), np.array(seen["samples"])))
        seen["photometric"] = str(page.photometric.name)
    print(json.dumps(seen))
