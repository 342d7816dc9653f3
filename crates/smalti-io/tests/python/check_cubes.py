"""Writes spectral cubes with SPy, NumPy, tifffile and OpenCV for us to read, reads ours with them, and times NumPy."""

import json
import sys
import time
import zlib
from pathlib import Path

import numpy as np

mode, folder = sys.argv[1], Path(sys.argv[2])
ROWS, COLS, BANDS = 5, 7, 6
NM = [400.0 + 20.0 * i for i in range(BANDS)]
# Row, column, band.
CUBE = (np.arange(ROWS * COLS * BANDS).reshape(ROWS, COLS, BANDS) * 37 % 251).astype(np.float64)
DTYPES = ["uint8", "int16", "int32", "float32", "float64", "uint16", "uint32", "int64", "uint64"]


def envi(write):
    import spectral.io.envi as io

    if write:
        for dtype in DTYPES:
            for interleave in ["bsq", "bil", "bip"]:
                for order in [0, 1]:
                    name = folder / f"{dtype}-{interleave}-{order}.hdr"
                    io.save_image(str(name), CUBE.astype(dtype), dtype=dtype, interleave=interleave, byteorder=order,
                                  metadata={"wavelength": NM, "wavelength units": "Nanometers"})
                    print(json.dumps(name.name))
        name = folder / "complex.hdr"
        io.save_image(str(name), CUBE.astype("complex64"), dtype="complex64", metadata={"wavelength": NM})
    else:
        for name in ["bsq", "bil", "bip"]:
            image = io.open(folder / f"{name}.hdr", folder / f"{name}.{name}")
            cube = np.asarray(image.load()).transpose(2, 0, 1)
            print(json.dumps({"values": cube.ravel().tolist(), "nm": image.bands.centers, "unit": image.bands.band_unit}))


def numpy(write):
    if write:
        for dtype in ["<f4", ">f4", "<f8", ">f8", "<f2", "u1", "i1", "<u2", ">u2", "<u4", ">i2", "<i4", "<i8", ">u8"]:
            for order in ["C", "F"]:
                for axes, name in [((2, 0, 1), "brc"), ((0, 1, 2), "rcb"), ((0, 2, 1), "rbc")]:
                    cube = np.array((CUBE / 2).astype(dtype).transpose(axes), order=order)
                    stem = f"{dtype.replace('<', 'l').replace('>', 'b')}-{order}-{name}"
                    np.save(folder / f"{stem}.npy", cube)
                    save = np.savez_compressed if order == "F" else np.savez
                    save(folder / f"{stem}.npz", cube=cube, wavelengths=np.array(NM), quantity="reflectance", distance=2.5)
                    print(json.dumps([stem, (CUBE / 2).astype(dtype).transpose(2, 0, 1).astype("f4").ravel().tolist()]))
    else:
        with np.load(folder / "ours.npz") as z:
            print(json.dumps({k: z[k].tolist() for k in z.files if k != "cube"} | {"shape": z["cube"].shape,
                  "values": z["cube"].ravel().tolist(), "dtype": str(z["cube"].dtype)}))


def tiff(write):
    import tifffile

    if write:
        planes = CUBE.transpose(2, 0, 1)
        labels = [f"{nm:g} nm" for nm in NM]
        for dtype in ["uint8", "uint16", "float32", "float64"]:
            for name, data, options in [
                ("pages", planes, {"photometric": "minisblack", "metadata": {"labels": labels}}),
                ("planar", planes, {"photometric": "minisblack", "planarconfig": "separate", "metadata": {"labels": labels}}),
                ("chunky", CUBE, {"photometric": "minisblack", "planarconfig": "contig", "metadata": {"wavelengths": NM}}),
                ("zlib", planes, {"photometric": "minisblack", "compression": "zlib", "rowsperstrip": 2,
                                  "metadata": {"labels": labels}}),
                ("tiled", planes, {"photometric": "minisblack", "tile": (16, 16), "metadata": {"labels": labels}}),
                ("strips", CUBE, {"photometric": "minisblack", "planarconfig": "contig", "rowsperstrip": 2,
                                  "metadata": {"wavelengths": NM}}),
                ("big", planes, {"photometric": "minisblack", "bigtiff": True, "byteorder": ">", "metadata": {"labels": labels}}),
                ("silent", planes, {"photometric": "minisblack", "metadata": None}),
            ]:
                tifffile.imwrite(folder / f"{name}-{dtype}.tif", data.astype(dtype), **options)
                print(json.dumps(f"{name}-{dtype}.tif"))
            with tifffile.TiffWriter(folder / f"names-{dtype}.tif") as out:
                for plane, label in zip(planes, labels):
                    out.write(plane.astype(dtype), description=label, metadata=None)
            print(json.dumps(f"names-{dtype}.tif"))
        tifffile.imwrite(folder / "imagej-float32.tif", planes.astype("f4"), imagej=True, metadata={"axes": "CYX", "Labels": labels})
        print(json.dumps("imagej-float32.tif"))
        tifffile.imwrite(folder / "rgb.tif", CUBE[:, :, :3].astype("u1"), photometric="rgb")
        tifffile.imwrite(folder / "grey.tif", CUBE[:, :, 0].astype("u1"))
    else:
        for name in ["pages", "pages-deflate", "samples", "samples-deflate"]:
            data = tifffile.imread(folder / f"{name}.tif")
            data = data if name.startswith("pages") else data.transpose(2, 0, 1)
            with tifffile.TiffFile(folder / f"{name}.tif") as file:
                stated = json.loads(file.pages[0].description)["wavelengths_nm"]
            print(json.dumps({"values": data.ravel().tolist(), "dtype": str(data.dtype), "nm": stated}))


def bands(write):
    import cv2

    for name, pixel in [("grey_ms", lambda p: p), ("rgba_ms", lambda p: np.dstack([p, p, p, np.full_like(p, 65535)]))]:
        (folder / name).mkdir()
        for i in range(31):
            plane = (CUBE[:, :, i % BANDS] * 100 + i).astype("u2")
            cv2.imwrite(str(folder / name / f"{name}_{i + 1:02}.png"), pixel(plane))
    cv2.imwrite(str(folder / "grey_ms" / "preview.png"), np.zeros((2, 2, 3), "u1"))
    print(json.dumps([(CUBE[:, :, i % BANDS] * 100 + i).ravel().tolist() for i in range(31)]))


def speed(write):
    """Best of nine, each file read and brought to planes of f32; seconds. The yardstick is NumPy's own time for the same numbers:
    `fromfile` or `load` of them in the order and type of the file (where the file is compressed, of an archive that is; of a TIFF, its
    own strips through zlib), and what brings them to planes. Where another program reads the file faster than that, it is the yardstick."""
    rows, cols, count = 512, 512, 31
    cube = (np.random.default_rng(1).random((rows, cols, count)) * 60000).astype("u2")
    planes = np.ascontiguousarray(cube.transpose(2, 0, 1))
    nm = np.arange(400.0, 701.0, 10.0)

    def best(read):
        times = []
        for _ in range(9):
            start = time.perf_counter()
            got = read()
            times.append(time.perf_counter() - start)
            assert got.shape == (count, rows, cols) and got.dtype == np.float32 and got.flags.c_contiguous
        return min(times)

    def planar(a, axes=None):
        return np.ascontiguousarray(a if axes is None else a.transpose(axes), dtype=np.float32)

    def numpys(name, data, compressed, back):
        """The same numbers as NumPy keeps them."""
        if compressed:
            np.savez_compressed(folder / f"{name}-numpy.npz", a=data)
            return lambda: planar(np.load(folder / f"{name}-numpy.npz")["a"], back)
        data.tofile(folder / f"{name}-numpy")
        return lambda: planar(np.fromfile(folder / f"{name}-numpy", data.dtype).reshape(data.shape), back)

    def strips(name, data):
        """The strips of a TIFF, of planes, unpacked by zlib."""
        with tifffile.TiffFile(folder / f"{name}.tif") as file:
            places = [p for page in file.pages for p in zip(page.dataoffsets, page.databytecounts)]

        def read():
            whole = memoryview(np.fromfile(folder / f"{name}.tif", "u1"))
            unpacked = [np.frombuffer(zlib.decompress(whole[at:at + count]), data.dtype) for at, count in places]
            return planar(np.concatenate(unpacked).reshape(data.shape))

        return read

    jobs = []
    header = ("ENVI\nsamples = 512\nlines = 512\nbands = 31\ndata type = {}\ninterleave = {}\nbyte order = {}\n"
              "wavelength units = nm\nwavelength = {{" + ",".join(map(str, nm)) + "}}\n")
    for kind, dtype, order in [(4, "<f4", 0), (12, "<u2", 0), (12, ">u2", 1), (5, "<f8", 0)]:
        for interleave, axes, back in [("bsq", (2, 0, 1), None), ("bil", (0, 2, 1), (1, 0, 2)), ("bip", (0, 1, 2), (2, 0, 1))]:
            stem = folder / f"{interleave}-{dtype[1:]}-{order}"
            data = np.ascontiguousarray(cube.transpose(axes).astype(dtype))
            data.tofile(f"{stem}.img")
            Path(f"{stem}.hdr").write_text(header.format(kind, interleave, order))
            shape = data.shape
            jobs.append((f"{stem.name}.hdr", lambda s=stem, d=dtype, h=shape, b=back: planar(np.fromfile(f"{s}.img", d).reshape(h), b)))
    for order in ["C", "F"]:
        for dtype in ["f4", "u2"]:
            np.save(folder / f"rcb-{order}-{dtype}.npy", np.array(cube.astype(dtype), order=order))
            jobs.append((f"rcb-{order}-{dtype}.npy", lambda o=order, d=dtype: planar(np.load(folder / f"rcb-{o}-{d}.npy"), (2, 0, 1))))
    np.savez(folder / "stored.npz", cube=planes.astype("f4"), wavelengths=nm)
    jobs.append(("stored.npz", lambda: planar(np.load(folder / "stored.npz")["cube"])))
    np.savez_compressed(folder / "deflated.npz", cube=planes, wavelengths=nm)
    jobs.append(("deflated.npz", lambda: planar(np.load(folder / "deflated.npz")["cube"])))
    for order in ["C", "F"]:
        np.savez_compressed(folder / f"deflated-rcb-{order}.npz", cube=np.array(cube, order=order), wavelengths=nm)
        jobs.append((f"deflated-rcb-{order}.npz", lambda o=order: planar(np.load(folder / f"deflated-rcb-{o}.npz")["cube"], (2, 0, 1))))
    import tifffile
    meta = {"wavelengths": nm.tolist()}
    for name, data, options, back in [("pages-f4", planes.astype("f4"), {}, None), ("pages-u2", planes, {}, None),
                                      ("zlib-u2", planes, {"compression": "zlib"}, None),
                                      ("chunky-f4", cube.astype("f4"), {"planarconfig": "contig"}, (2, 0, 1))]:
        tifffile.imwrite(folder / f"{name}.tif", data, photometric="minisblack", metadata=meta, **options)
        jobs.append((f"{name}.tif", lambda n=name, b=back: planar(tifffile.imread(folder / f"{n}.tif"), b),
                     strips(name, data) if "compression" in options else numpys(name, data, False, back)))
    import OpenEXR
    channels = [f"S0.{v:.0f},0nm" for v in nm]

    def exr(name):
        with OpenEXR.File(str(folder / name), separate_channels=True) as file:
            return np.stack([file.channels()[c].pixels for c in channels]).astype(np.float32)

    for name, dtype, code in [("plain-f4", "f4", OpenEXR.NO_COMPRESSION), ("zip-f4", "f4", OpenEXR.ZIP_COMPRESSION),
                              ("zip-f2", "f2", OpenEXR.ZIP_COMPRESSION)]:
        # Halves end at 65504.
        data = planes.astype(dtype)
        OpenEXR.File({"compression": code, "type": OpenEXR.scanlineimage}, dict(zip(channels, data))).write(str(folder / f"{name}.exr"))
        jobs.append((f"{name}.exr", lambda n=name: exr(f"{n}.exr"), numpys(name, data, code != OpenEXR.NO_COMPRESSION, None)))
    import cv2
    (folder / "cave").mkdir()
    for i in range(count):
        cv2.imwrite(str(folder / "cave" / f"s_{i + 1:02}.png"), planes[i])
    jobs.append(("cave", lambda: np.stack([cv2.imread(str(folder / "cave" / f"s_{i + 1:02}.png"), -1) for i in range(count)])
                 .astype(np.float32), numpys("cave", planes, True, None)))
    for name, *readers in jobs:
        print(json.dumps([name, min(best(read) for read in readers)]), flush=True)


{"envi": envi, "numpy": numpy, "tiff": tiff, "bands": bands, "speed": speed}[mode.split("-")[0]](mode.endswith("write"))
