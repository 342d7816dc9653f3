"""Reads spectral OpenEXR with the OpenEXR package and prints it as JSON, or writes some for us to read."""

import json
import sys

import numpy as np
import OpenEXR

mode, folder = sys.argv[1:]
if mode == "read":
    for name in ["fichet.exr", "pbrt.exr"]:
        with OpenEXR.File(f"{folder}/{name}", separate_channels=True) as file:
            header = file.header()
            channels = {k: c.pixels.ravel().tolist() for k, c in file.channels().items()}
            print(json.dumps({
                "channels": channels,
                "units": header.get("emissiveUnits"),
                "version": header.get("spectralLayoutVersion"),
                "comments": json.loads(header["comments"])["smalti"],
            }))
else:
    bands = {f"S0.{nm},0nm": np.full((3, 5), nm, np.float32) for nm in range(400, 701, 20)}
    header = {"compression": OpenEXR.PIZ_COMPRESSION, "type": OpenEXR.scanlineimage,
              "spectralLayoutVersion": "1.0", "emissiveUnits": "W.m^-2.sr^-1"}
    OpenEXR.File(header, bands).write(f"{folder}/emissive.exr")
    bands = {f"T.{nm / 1000:.3f}um".replace(".", ",").replace("T,", "T."): np.full((3, 5), nm / 1000, np.float16)
             for nm in range(400, 701, 50)}
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, bands).write(f"{folder}/reflective.exr")
    rgb = np.dstack([np.full((3, 5), v, np.float32) for v in (0.25, 0.5, 2.0)])
    OpenEXR.File({"compression": OpenEXR.PXR24_COMPRESSION, "type": OpenEXR.scanlineimage}, {"RGB": rgb}).write(f"{folder}/rgb.exr")
