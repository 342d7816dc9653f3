"""SciPy and h5py write files for us, and read ours.

Sample (r, c, b) of every cube is (r + 5 c + 20 b) % 120 + 1, of rows x columns x bands = 5 x 4 x 7."""
import json
import pathlib
import sys
import time

import h5py
import numpy as np
import scipy.io

mode, folder = sys.argv[1], pathlib.Path(sys.argv[2])
R, C, B = 5, 4, 7
r, c, b = np.meshgrid(np.arange(R), np.arange(C), np.arange(B), indexing="ij")
CUBE = (r + 5 * c + 20 * b) % 120 + 1
WAVE = 400.0 + 50.0 * np.arange(B)
LIGHT = np.linspace(1.0, 2.0, B)
# Groups and indices of chunks as HDF5 1.10 and later have them.
NEWER = ("v110", "v114")
TYPES = ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"]


def illuminant():
    return {"name": "D65", "type": "illuminant", "spectrum": {"wave": WAVE}, "data": {"photons": LIGHT}}


def v5():
    beside = {"wave": WAVE, "illuminant": illuminant(), "fov": 12.5, "dist": 2.0, "name": "scipy"}
    for t in TYPES:
        for z in (False, True):
            # The cube last: what stands before it is skipped.
            variables = {**beside, "comment": "a comment", "photons": CUBE.astype(t)}
            scipy.io.savemat(folder / f"photons_{t}{'z' * z}.mat", variables, do_compression=z)
    scene = {
        "type": "scene", "name": "ä scene", "distance": 3.0, "wAngular": 20.0,
        "spectrum": {"wave": WAVE[:, None]}, "data": {"photons": CUBE * 1e15},
        "illuminant": {**illuminant(), "data": {"photons": np.broadcast_to(LIGHT, (R, C, B))}},
        "odd": np.array([{"a": 1}, "b"], dtype=object), "depthMap": np.ones((R, C)), "flag": True,
    }
    scipy.io.savemat(folder / "scene.mat", {"scene": scene}, do_compression=True)
    packed = np.round((CUBE - 1) / 119 * 65535).astype("u2")
    old = {**scene, "data": {"photons": packed, "dmin": 1.0, "dmax": 120.0, "bitDepth": 16.0}}
    scipy.io.savemat(folder / "packed.mat", {"scene": old})

    flat = CUBE.reshape(-1, B).astype(float)
    mean = flat.mean(axis=0)
    u, s, vt = np.linalg.svd(flat - mean, full_matrices=False)
    compressed = {
        "mcCOEF": (u * s).reshape(R, C, -1), "basis": {"basis": vt.T, "wave": WAVE}, "imgMean": mean,
        "comment": "pca", "fov": 8.0, "dist": 1.5,
        # The form of before 2012: energy.
        "illuminant": {"data": LIGHT, "wavelength": WAVE},
    }
    scipy.io.savemat(folder / "mccoef.mat", compressed)
    del compressed["imgMean"]
    u, s, vt = np.linalg.svd(flat, full_matrices=False)
    compressed |= {"mcCOEF": (u * s).reshape(R, C, -1), "basis": {"basis": vt.T, "wave": WAVE}}
    scipy.io.savemat(folder / "mccoef_without_mean.mat", compressed, do_compression=True)
    scipy.io.savemat(folder / "level4.mat", {"x": CUBE[:, :, 0].astype(float)}, format="4")
    scipy.io.savemat(folder / "complex.mat", {"cube": CUBE + 1j, "bands": WAVE})


def v73(name, fill, **options):
    with h5py.File(folder / name, "w", userblock_size=512, **options) as f:
        fill(f)
    with open(folder / name, "r+b") as f:
        f.write(b"MATLAB 7.3 MAT-file".ljust(116) + bytes(8) + b"\x00\x02IM")


def put(where, name, value, kind=None, **options):
    """As MATLAB: axes the other way round, the class in an attribute."""
    value = np.atleast_2d(np.asarray(value))
    d = where.create_dataset(name, data=value.T, **options)
    names = {"f8": "double", "f4": "single", "u2": "uint16"}
    d.attrs["MATLAB_class"] = np.bytes_(kind or names.get(value.dtype.str[1:], "double"))
    return d


def text(where, name, value):
    d = put(where, name, np.frombuffer(value.encode("utf-16-le"), "u2"), "char")
    d.attrs["MATLAB_int_decode"] = np.int32(2)


def struct(where, name):
    g = where.create_group(name)
    g.attrs["MATLAB_class"] = np.bytes_("struct")
    return g


def put_illuminant(where):
    light = struct(where, "illuminant")
    text(light, "type", "illuminant")
    put(struct(light, "spectrum"), "wave", WAVE)
    put(struct(light, "data"), "photons", LIGHT)


ZIPPED = {"chunks": (2, 3, 4), "compression": "gzip", "shuffle": True}


def hdf5():
    def photons(f, **options):
        put(f, "photons", CUBE.astype("f4"), **options)
        put(f, "wave", WAVE)
        put(f, "fov", 12.5)
        put(f, "dist", 2.0)
        text(f, "name", "h5py")
        put_illuminant(f)

    def scene(f):
        s = struct(f, "scene")
        text(s, "name", "ä scene")
        put(s, "distance", 3.0)
        put(s, "wAngular", 20.0)
        put(struct(s, "spectrum"), "wave", WAVE[:, None])
        put(struct(s, "data"), "photons", CUBE * 1e15, **ZIPPED)
        put_illuminant(s)
        # Cells refer to what lies elsewhere.
        refs = f.create_group("#refs#")
        text(refs, "b", "in a cell")
        for name, count in (("one", 1), ("two", 2)):
            d = s.create_dataset(name, (count, 1), h5py.ref_dtype)
            d[:] = refs["b"].ref
            d.attrs["MATLAB_class"] = np.bytes_("cell")
        empty = s.create_dataset("filename", data=np.array([0, 0], "u8"))
        empty.attrs["MATLAB_class"] = np.bytes_("char")
        empty.attrs["MATLAB_empty"] = np.uint8(1)

    def mccoef(f):
        flat = CUBE.reshape(-1, B).astype(float)
        mean = flat.mean(axis=0)
        u, s, vt = np.linalg.svd(flat - mean, full_matrices=False)
        put(f, "mcCOEF", (u * s).reshape(R, C, -1), **ZIPPED)
        basis = struct(f, "basis")
        put(basis, "basis", vt.T)
        put(basis, "wave", WAVE)
        put(f, "imgMean", mean)
        put_illuminant(f)

    v73("v73_photons.mat", photons)
    v73("v73_photons_zipped.mat", lambda f: photons(f, **ZIPPED))
    v73("v73_scene.mat", scene)
    v73("v73_mccoef.mat", mccoef)
    v73("v73_newer.mat", scene, libver=NEWER)

    def icvl(f):
        put(f, "rad", CUBE.astype("f8"), **ZIPPED)
        put(f, "rgb", np.zeros((R, C, 3)))
        put(f, "bands", WAVE)

    def arad(f):
        put(f, "cube", CUBE / 120)
        put(f, "bands", WAVE)
        put(f, "norm_factor", 0.5)

    v73("icvl.mat", icvl)
    v73("arad.mat", arad)
    with h5py.File(folder / "kaust.h5", "w") as f:
        wide = np.concatenate([CUBE] * 5, axis=2)[:, :, :34]
        f["img\\"] = (wide / 120).transpose().astype("f4")

    for t in TYPES:
        for order in "<>":
            name = f"generic_{t}{'_big' if order == '>' else ''}.h5"
            with h5py.File(folder / name, "w") as f:
                f["stack"] = CUBE.transpose(2, 0, 1).astype(order + t)
                f["wavelengths"] = WAVE / 1000
                f["wavelengths"].attrs["units"] = "um"
    storages = {
        "chunked": {"chunks": (2, 3, 4)},
        "one_chunk": {"chunks": (R, C, B)},
        "zipped": ZIPPED,
        "deflated": {"chunks": (2, 3, 4), "compression": "gzip"},
        "shuffled": {"chunks": (2, 3, 4), "shuffle": True},
        "checked": {**ZIPPED, "fletcher32": True},
        "lzf": {"chunks": (2, 3, 4), "compression": "lzf"},
        "growing": {**ZIPPED, "maxshape": (None, C, B)},
    }
    for name, options in storages.items():
        for libver in ("earliest", "v110"):
            bounds = NEWER if libver == "v110" else libver
            with h5py.File(folder / f"stored_{name}_{libver}.h5", "w", libver=bounds) as f:
                d = f.create_group("a/b").create_dataset("x", data=CUBE.astype("f4"), **options)
                d.attrs["wavelength"] = WAVE
    with h5py.File(folder / "in_part.h5", "w") as f:
        d = f.create_dataset("x", (R, C, B), "f4", chunks=(2, 3, 4), fillvalue=3)
        d[:2, :3, :4] = 5
        f["wave"] = WAVE
    with h5py.File(folder / "two.h5", "w") as f:
        f["a"] = CUBE.astype("f4")
        f["b"] = CUBE[::-1].astype("f4")
        f["wave"] = WAVE


def read():
    """What we wrote, as SciPy and h5py see it."""
    s = scipy.io.loadmat(folder / "ours.mat", squeeze_me=True, struct_as_record=False)["scene"]
    print(json.dumps({
        "class": str(s.data.photons.dtype), "photons": s.data.photons.astype(float).tolist(),
        "wave": s.spectrum.wave.tolist(), "light": s.illuminant.data.photons.tolist(),
        "distance": s.distance, "fov": s.wAngular, "name": s.name, "type": s.type,
    }))
    with h5py.File(folder / "ours73.mat") as f:
        s = f["scene"]
        name = "".join(chr(u) for u in s["name"][()].ravel())
        print(json.dumps({
            "class": s["data/photons"].attrs["MATLAB_class"].decode(),
            "photons": s["data/photons"][()].T.tolist(), "wave": s["spectrum/wave"][()].ravel().tolist(),
            "light": s["illuminant/data/photons"][()].ravel().tolist(),
            "distance": float(s["distance"][0, 0]), "fov": float(s["wAngular"][0, 0]), "name": name,
            "type": s.attrs["MATLAB_class"].decode(),
        }))
    with h5py.File(folder / "ours.h5") as f:
        print(json.dumps({
            "cube": f["cube"][()].tolist(), "wave": f["wavelengths"][()].tolist(),
            "units": f["wavelengths"].attrs["units"], "quantity": f["cube"].attrs["quantity"],
        }))


def timed():
    """Cubes of 512 x 512 x 31, and the best of several times: SciPy or h5py loading each and making it planes in single
    precision (`theirs`), and NumPy's own time for the same numbers (`numpy`): loaded from a file that has them in the same type and
    order, compressed where the cube is, and made planes."""
    rng = np.random.default_rng(1)
    smooth = np.linspace(0, 1, 512)[:, None, None] + 0.01 * rng.random((512, 512, 31))
    wave = 400.0 + 10.0 * np.arange(31)
    # What is planes when its axes are turned so.
    back = {}
    raw = {}

    def add(name, data, turn, write):
        write(folder / name)
        back[name] = turn
        raw[name] = (data, "zipped" in name or "shuffled" in name)

    def h5(data, name="cube", bands="bands", **options):
        def write(path):
            with h5py.File(path, "w") as f:
                f.create_dataset(name, data=data, **options)
                f[bands] = wave
                if path.suffix == ".mat":
                    f[name].attrs["MATLAB_class"] = np.bytes_("double")
        return write

    for t in ("u2", "f4", "f8"):
        cube = (smooth * 4000).astype(t)
        stack = np.ascontiguousarray(cube.transpose(2, 0, 1))
        turned = np.ascontiguousarray(cube.transpose(2, 1, 0))
        for z in (False, True):
            save = lambda path, z=z: scipy.io.savemat(path, {"photons": cube, "wave": wave}, do_compression=z)
            add(f"{t}{'_zipped' * z}.mat", np.asfortranarray(cube), (2, 0, 1), save)
        add(f"{t}_v73.mat", turned, (0, 2, 1), h5(turned, "photons", "wave"))
        add(f"{t}_v73_zipped.mat", turned, (0, 2, 1),
            h5(turned, "photons", "wave", chunks=(1, 64, 512), compression="gzip", compression_opts=3))
        add(f"{t}.h5", stack, (0, 1, 2), h5(stack))
        add(f"{t}_interleaved.h5", cube, (2, 0, 1), h5(cube))
        add(f"{t}_zipped.h5", stack, (0, 1, 2), h5(stack, chunks=(1, 64, 512), compression="gzip"))
        add(f"{t}_shuffled.h5", stack, (0, 1, 2), h5(stack, chunks=True, compression="gzip", shuffle=True))
        add(f"{t}_pixels_zipped.h5", cube, (2, 0, 1), h5(cube, chunks=(16, 64, 31), compression="gzip"))

    def best(load):
        times = []
        for _ in range(7):
            start = time.perf_counter()
            planes = load()
            times.append(time.perf_counter() - start)
            assert planes.shape == (31, 512, 512) and planes.dtype == np.float32 and planes.flags.c_contiguous
        return min(times)

    def theirs(path):
        if path.suffix == ".mat" and "v73" not in path.name:
            cube = scipy.io.loadmat(path)["photons"]
        else:
            with h5py.File(path) as f:
                cube = next(f[n] for n in ("cube", "photons") if n in f)[()]
        return np.ascontiguousarray(cube.transpose(back[path.name]), dtype="f4")

    for name, (data, packed) in raw.items():
        kept = folder / ("numpy.npz" if packed else "numpy.npy")
        np.savez_compressed(kept, a=data) if packed else np.save(kept, data)
        turn = back[name]
        load = lambda: np.load(kept)["a"] if packed else np.load(kept)
        numpys = best(lambda: np.ascontiguousarray(load().transpose(turn), dtype="f4"))
        print(json.dumps({"name": name, "numpy": numpys, "theirs": best(lambda: theirs(folder / name))}), flush=True)

    # Photons as six coefficients a pixel.
    coefficients, basis, mean = rng.random((512, 512, 6)), rng.random((31, 6)), np.full(31, 10.0)
    held = {"mcCOEF": coefficients, "basis": {"basis": basis, "wave": wave}, "imgMean": mean}
    scipy.io.savemat(folder / "mccoef.mat", held)
    np.save(folder / "numpy.npy", np.asfortranarray(coefficients))

    def product(coefficients):
        flat = coefficients.transpose(2, 0, 1).reshape(6, -1)
        return (basis @ flat + mean[:, None]).astype("f4").reshape(31, 512, 512)

    numpys = best(lambda: product(np.load(folder / "numpy.npy")))
    loaded = best(lambda: product(scipy.io.loadmat(folder / "mccoef.mat")["mcCOEF"]))
    print(json.dumps({"name": "mccoef.mat", "numpy": numpys, "theirs": loaded}), flush=True)


if mode == "write":
    v5()
    hdf5()
elif mode == "time":
    timed()
else:
    read()
