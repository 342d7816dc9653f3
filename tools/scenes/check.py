"""python -m scenes check: does a rendering give back the reflectance of a known card, and are the test spectra not those of training?"""

import pathlib

import mitsuba as mi
import numpy as np

from . import codec, material, render, spectra

CARDS = ["TCS 5", "TCS 32", "TCS 76", "Skin 36", "Cotton Fabric GDS437 White"]


STORED = pathlib.Path(__file__).parents[2] / "crates/smalti-io/tests/data/cards"


def recovered() -> float:
    """Largest relative error of the mean reflectance of cards under an LED lamp at 40°, rendered, stored and decoded.

    Each card, with the light that a white diffuser in its place reflects, is stored for the tests of smalti-io."""
    worst = 0.0
    STORED.mkdir(exist_ok=True)
    t = mi.ScalarTransform4f()
    angle = np.radians(40.0)
    irradiance = spectra.irradiance("LED-B3", 1000.0)
    for name in CARDS:
        scene = mi.load_dict(
            {
                "type": "scene",
                "sun": {
                    "type": "directional",
                    "direction": [float(np.sin(angle)), 0.0, -float(np.cos(angle))],
                    "irradiance": material.spectrum(irradiance),
                },
                "card": {"type": "rectangle", "bsdf": material.diffuse(None, [name])},
            }
        )
        sensor = mi.load_dict({"type": "perspective", "fov": 20.0, "to_world": t.look_at([0, 0, 3], [0, 0, 0], [0, 1, 0])})
        picture = render.render(scene, sensor, 12, 16, 16, 1).radiance
        encoded = codec.encode(picture, irradiance * np.cos(angle) / np.pi, {"card": name, "lamp": "LED-B3"}, 3)
        (STORED / f"{name.replace(' ', '-').lower()}.spc").write_bytes(encoded)
        stored = codec.decode(encoded)
        reflectance = stored.radiance.mean(axis=(0, 1)) / stored.light
        truth = spectra.reflectances()[name]
        error = float(np.abs(reflectance / truth - 1).max())
        print(f"{name}: largest error of a band {100 * error:.2f} %")
        worst = max(worst, error)
    return worst


def interreflection() -> float:
    """Relative error of the radiance in a closed box of grey walls that shine: L = Lₑ / (1 − ρ), by a path of 60 bounces."""
    lamp = spectra.radiance("HP1", 100.0)
    wall = {
        "type": "sphere",
        "radius": 1.0,
        "flip_normals": True,
        "bsdf": material.diffuse(None, ["TCS 45"]),
        "emitter": {"type": "area", "radiance": material.spectrum(lamp)},
    }
    sensor = mi.load_dict({"type": "perspective", "fov": 40.0, "to_world": mi.ScalarTransform4f().look_at([0, 0, 0], [1, 0, 0], [0, 0, 1])})
    got = render.render(mi.load_dict({"type": "scene", "wall": wall}), sensor, 16, 16, 256, 3, 60).radiance.mean(axis=(0, 1))
    truth = lamp / (1 - spectra.reflectances()["TCS 45"])
    error = float(np.abs(got / truth - 1).max())
    print(f"closed box: largest error of a band {100 * error:.2f} %")
    return error


def nearest_to_training() -> float:
    """Smallest rms distance between a reflectance of the test scenes and one of the training set."""
    names, training = list(spectra.training()), np.array(list(spectra.training().values()))
    best = (1.0, "", "")
    for name, values in spectra.reflectances().items():
        d = np.sqrt(((training - values) ** 2).mean(axis=1))
        best = min(best, (float(d.min()), name, names[int(d.argmin())]))
    print(f"nearest pair of test and training: {best[1]} and {best[2]}, rms distance {best[0]:.4f}")
    return best[0]


def main() -> int:
    """0 if every check holds."""
    ok = recovered() < 0.02
    ok &= interreflection() < 0.02
    ok &= nearest_to_training() > 0.001
    print("passed" if ok else "FAILED")
    return 0 if ok else 1
