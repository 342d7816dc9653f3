"""python -m scenes render NAME … | store NAME | sheet | photos SMALTI | check | collect …"""

import argparse
import importlib
import json
import os
import pathlib
import sys
import time

import numpy as np

NAMES = ["portrait", "foliage", "table", "street", "shelf", "interior"]
# Training scenes: a script and its seed.
TRAINING = ["clutter-1", "clutter-2"]
ROWS, COLS = 576, 768
STORE = pathlib.Path(__file__).resolve().parents[2] / "crates/smalti-scenes/data"


def variant() -> None:
    """Chooses Mitsuba's vectorised spectral variant and two threads."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_spectral")
    dr.set_thread_count(int(os.environ.get("SCENES_THREADS", "2")))
    from . import material

    material.register()


def white_of(module: object, scene_dict: dict) -> np.ndarray:  # type: ignore[type-arg]
    """The light as spectral radiance of a perfect white: a lamp, or that of the emitters on a card towards the sun."""
    import mitsuba as mi

    from . import render, spectra

    name = module.WHITE  # type: ignore[attr-defined]
    if name != "probe":
        return spectra.radiance(name, 100.0)
    t = mi.ScalarTransform4f()
    sun = list(module.SUN)  # type: ignore[attr-defined]
    card = {
        "type": "scene",
        "sky": scene_dict["sky"],
        "card": {
            "type": "disk",
            "to_world": t.look_at([0, 0, 0], sun, [0.1, 0.2, 1]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "uniform", "value": 1.0}},
        },
    }
    p = np.array(sun) / np.linalg.norm(sun)
    sensor = mi.load_dict({"type": "perspective", "fov": 5.0, "to_world": t.look_at([float(v) for v in 3 * p], [0, 0, 0], [0.1, 0.2, 1])})
    return render.render(mi.load_dict(card), sensor, 8, 8, 4096, 5, 2).radiance.mean(axis=(0, 1))


def script(name: str) -> object:
    """The module of a scene, whose name may end in a seed."""
    return importlib.import_module(f"scenes.{name.partition('-')[0]}")


def camera(c: dict, rows: int, cols: int) -> object:  # type: ignore[type-arg]
    """A thin-lens camera."""
    import mitsuba as mi

    focus = c.get("focus", float(np.linalg.norm(np.array(c["target"]) - np.array(c["origin"]))))
    return mi.load_dict(
        {
            "type": "thinlens",
            "fov": c["fov"],
            "aperture_radius": c.get("aperture", 0.001),
            "focus_distance": focus,
            "near_clip": 0.01,
            "far_clip": 1000.0,
            "to_world": mi.ScalarTransform4f().look_at(c["origin"], c["target"], c.get("up", [0, 0, 1])),
            "film": {"type": "hdrfilm", "width": cols, "height": rows},
        }
    )


def render_scene(name: str, scale: int, spp: int, out: pathlib.Path, seeds: list[int], clean: bool) -> None:
    """Renders one file per seed: independent estimates, which `store` joins and compares."""
    variant()
    import mitsuba as mi

    from . import picture, render, spectra

    module = script(name)
    rows, cols = getattr(module, "SIZE", (ROWS, COLS))
    start = time.time()
    number = name.partition("-")[2]
    scene_dict, view = module.build(int(number)) if number else module.build()
    scene = mi.load_dict(scene_dict)
    print(f"{name}: geometry {time.time() - start:.0f} s", flush=True)
    white = white_of(module, scene_dict)
    out.mkdir(parents=True, exist_ok=True)
    for seed in seeds:
        r = render.render(scene, camera(view, rows, cols), rows // scale, cols // scale, spp, seed, module.DEPTH)
        start = time.time()
        image = render.denoise(r) if clean else r.radiance
        print(
            f"{name}: {spp} samples {r.seconds:.0f} s, denoised {time.time() - start:.0f} s; "
            f"luminance {np.percentile(spectra.luminance(image), [1, 50, 99]).round(3)}",
            flush=True,
        )
        picture.save(out / f"{name}-{seed}.png", image, white, getattr(module, "PERCENTILE", 99.0))
        if scale == 1:
            np.savez(out / f"{name}-{seed}.npz", raw=r.radiance, clean=image, white=white, spp=spp, seconds=r.seconds)


def main() -> None:
    p = argparse.ArgumentParser()
    sub = p.add_subparsers(dest="verb", required=True)
    a = sub.add_parser("render")
    a.add_argument("name", choices=NAMES + TRAINING)
    a.add_argument("--scale", type=int, default=1)
    a.add_argument("--spp", type=int, default=32)
    a.add_argument("--seed", type=int, nargs="+", default=[1])
    a.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out"))
    a.add_argument("--raw", action="store_true")
    b = sub.add_parser("store")
    b.add_argument("name", choices=NAMES + TRAINING)
    b.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out"))
    c = sub.add_parser("collect")
    for key in ("usgs", "skin", "veg"):
        c.add_argument(f"--{key}", type=pathlib.Path, required=True)
    sub.add_parser("check")
    sub.add_parser("sheet")
    d = sub.add_parser("photos")
    d.add_argument("smalti", help="the command")
    args = p.parse_args()
    if args.verb == "render":
        render_scene(args.name, args.scale, args.spp, args.out, args.seed, not args.raw)
    elif args.verb == "store":
        variant()
        from . import store

        print(json.dumps(store.store(script(args.name), args.name, args.out, STORE), indent=1))
    elif args.verb == "sheet":
        variant()
        from . import sheet

        sheet.write(NAMES, STORE)
    elif args.verb == "photos":
        from . import photos

        photos.main(args.smalti)
    elif args.verb == "collect":
        from . import collect

        collect.collect(args.usgs, args.skin, args.veg)
    else:
        variant()
        from . import check

        sys.exit(check.main())


if __name__ == "__main__":
    main()
