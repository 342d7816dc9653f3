"""Reads pictures with OpenCV and tifffile: prints shape, type and samples (RGB) as JSON; writes some back."""

import json
import sys

import cv2
import numpy as np
import tifffile

mode, folder = sys.argv[1:]
if mode == "read":
    for name in ["p8.png", "p16.png", "t8.tif", "t16.tif"]:
        image = cv2.imread(f"{folder}/{name}", cv2.IMREAD_UNCHANGED)[..., ::-1]
        if name.endswith(".tif"):
            with tifffile.TiffFile(f"{folder}/{name}") as tif:
                assert np.array_equal(tif.pages[0].asarray(), image), name
                assert tif.pages[0].tags[34675].count > 400, "profile"
        print(json.dumps({"type": str(image.dtype), "shape": list(image.shape), "samples": image.ravel().tolist()}))
else:
    y, x = np.mgrid[0:24, 0:40]
    rgb = np.stack([x * 6, y * 10, (x + y) * 4], axis=-1)
    u8, u16, f32 = rgb.astype(np.uint8), (rgb * 257).astype(np.uint16), (rgb / 255).astype(np.float32)
    cv2.imwrite(f"{folder}/u8.png", u8[..., ::-1])
    cv2.imwrite(f"{folder}/u16.png", u16[..., ::-1])
    cv2.imwrite(f"{folder}/alpha.png", np.dstack([u8[..., ::-1], np.full((24, 40), 128, np.uint8)]))
    cv2.imwrite(f"{folder}/u8.jpg", u8[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 98])
    cv2.imwrite(f"{folder}/progressive.jpg", u8[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 98, cv2.IMWRITE_JPEG_PROGRESSIVE, 1])
    cv2.imwrite(f"{folder}/lzw.tif", u16[..., ::-1], [cv2.IMWRITE_TIFF_COMPRESSION, 5])
    tifffile.imwrite(f"{folder}/f32.tif", f32, photometric="rgb")
    tifffile.imwrite(f"{folder}/big.tif", u16, photometric="rgb", bigtiff=True, byteorder=">")
    tifffile.imwrite(f"{folder}/tiled.tif", u8, photometric="rgb", tile=(16, 16))
    tifffile.imwrite(f"{folder}/planar.tif", np.moveaxis(u8, -1, 0), photometric="rgb", planarconfig="separate")
    cv2.imwrite(f"{folder}/grey.png", u8[..., 0])
