"""Develops linear DNG files with LibRaw (rawpy) to linear sRGB and prints the rows, their pixels one after the other, as JSON: one object per file."""

import json
import sys

import rawpy

for path in sys.argv[1:]:
    with rawpy.imread(path) as raw:
        rgb = raw.postprocess(
            output_bps=16, gamma=(1, 1), no_auto_bright=True, use_camera_wb=True, user_flip=0,
            highlight_mode=rawpy.HighlightMode.Clip,
        )
    print(json.dumps({"shape": list(rgb.shape), "rows": rgb.reshape(rgb.shape[0], -1).tolist()}))
