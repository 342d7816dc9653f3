"""Develops linear DNG files with LibRaw (rawpy) to linear sRGB and prints the means of a patch as JSON: one object per file."""

import json
import sys

import rawpy

for path in sys.argv[1:]:
    with rawpy.imread(path) as raw:
        rgb = raw.postprocess(
            output_bps=16, gamma=(1, 1), no_auto_bright=True, use_camera_wb=True, user_flip=0,
            highlight_mode=rawpy.HighlightMode.Clip,
        )
    print(json.dumps({"shape": list(rgb.shape), "row": rgb[rgb.shape[0] // 2].tolist()}))
