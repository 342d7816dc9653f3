"""Two rooms full of things for training: printed boxes, lumpy balls, turned vases, draped cloth and a plant, of the reflectances of training.

Every lamp has the same spectrum, an equal-energy one, so that the light can be replaced: a path of any number of reflections is proportional to it.
"""

from typing import Any

import numpy as np

from . import material as m
from . import mesh, spectra, texture
from .table import ball, cloth_height

TITLE = "A room full of things, for training"
WHITE = "E"
DEPTH = 8
SIZE = (512, 512)
LIMIT = 500_000
LETTERS = list("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789")


def words(rng: np.random.Generator, count: int) -> str:
    """Words of random letters."""
    return " ".join("".join(rng.choice(LETTERS, rng.integers(2, 9))) for _ in range(count))


def label(rng: np.random.Generator, inks: int) -> np.ndarray:
    """A printed label: panels, discs, a title and lines of fine print; shares of the inks."""
    p = texture.Print(640, 480, inks)
    for _ in range(rng.integers(1, 4)):
        x, y, w, h = rng.uniform(0, 0.7), rng.uniform(0, 0.8), rng.uniform(0.15, 0.9), rng.uniform(0.05, 0.4)
        draw = p.ellipse if rng.random() < 0.3 else p.rectangle
        draw(x, y, min(x + w, 1.0), min(y + h, 1.0), int(rng.integers(1, inks)))
    p.text(rng.uniform(0.03, 0.2), rng.uniform(0.05, 0.5), words(rng, 1), int(rng.integers(50, 120)), int(rng.integers(1, inks)), bold=True)
    top, size, ink = rng.uniform(0.55, 0.7), int(rng.integers(11, 24)), int(rng.integers(1, inks))
    for line in range(int((0.96 - top) * 640 / (1.25 * size))):
        p.text(0.05, top + 1.25 * size * line / 640, words(rng, 12), size, ink)
    return p.shares()


def coat(rng: np.random.Generator, shares: np.ndarray, names: list[str]) -> dict[str, Any]:
    """A matt surface, or one below a clear layer."""
    if rng.random() < 0.4:
        return m.diffuse(shares, names)
    return m.plastic(shares, names, float(rng.uniform(0.05, 0.4)))


def build(seed: int) -> tuple[dict[str, Any], dict[str, Any]]:
    rng = np.random.default_rng(1000 + seed)
    every = sorted(spectra.training())

    def some(count: int) -> list[str]:
        return [str(n) for n in rng.choice(every, count, replace=False)]

    def mottled(rows: int, cols: int, count: int) -> np.ndarray:
        def noise() -> np.ndarray:
            return texture.noise(rows, cols, int(rng.integers(1 << 30)), rng.uniform(0.7, 1.7), 2)

        return texture.mix(*[0.8 * texture.ramp(noise(), -0.5, 1.5) for _ in range(count - 1)])

    scene: dict[str, Any] = {"type": "scene"}
    stones = [str(n) for n in rng.permutation([n for n in every if n.startswith("stone")])]
    over, height = texture.weave(768, 768, 48, seed)
    stripes = (np.arange(768)[None] // rng.integers(40, 90) % 2) * np.ones((768, 1))
    rug = texture.mix(np.clip(0.6 * over * stripes, 0, 1), 0.6 * (1 - texture.ramp(height, 0.1, 0.7)))
    scene["floor"] = mesh.shape(mesh.quad((-3, -2, 0), (6, 0, 0), (0, 5, 0), (0, 0, 9, 8)), m.diffuse(rug, some(3)), False)
    scene["wall"] = mesh.shape(mesh.quad((-3, 1.4, 0), (6, 0, 0), (0, 0, 3), (0, 0, 2, 1)), m.diffuse(mottled(512, 512, 3), stones[:3]), False)
    scene["side"] = mesh.shape(mesh.quad((1.9, -2, 0), (0, 5, 0), (0, 0, 3), (0, 0, 2, 1)), m.diffuse(mottled(512, 512, 2), stones[3:5]), False)
    x, y = np.meshgrid(np.linspace(-0.7, 0.7, 300), np.linspace(-0.45, 0.45, 260))
    over, height = texture.weave(512, 512, 60, 7 + seed)
    cloth = texture.mix(0.7 * over, 0.5 * (1 - texture.ramp(height, 0.1, 0.7)))
    folds = 0.02 + 4 * cloth_height(x, y, seed, 0.05)
    spread = mesh.grid(np.stack([x, y, folds], 2), (6.0, 4.0)).move((rng.uniform(-0.6, 0.2), -0.3, 0), 1.0, rng.uniform(0, 3))
    scene["cloth"] = mesh.shape(spread, m.diffuse(cloth, some(3)))
    for k in range(22):
        low = rng.uniform(0.12, 0.42, 3) * [1, 0.7, 1.5]
        place = (rng.uniform(-1.5, 1.4), rng.uniform(0.1, 1.2), 0.0)
        inks = int(rng.integers(3, 6))
        box = mesh.box((-low[0] / 2, -low[1] / 2, 0), (low[0] / 2, low[1] / 2, low[2])).move(place, 1.0, rng.normal(0, 0.5))
        scene[f"box{k}"] = mesh.shape(box, coat(rng, label(rng, inks), some(inks)), False)
    for k in range(16):
        radius = rng.uniform(0.05, 0.16)
        fruit = ball(50 * seed + 2 * k, rng.uniform(0, 0.02), rng.uniform(0.75, 1.1), rng.uniform(0, 0.2), 100)
        place = (rng.uniform(-1.2, 1.2), rng.uniform(-0.75, 0.3), radius)
        count = int(rng.integers(2, 5))
        scene[f"ball{k}"] = mesh.shape(fruit.move(place, radius, rng.uniform(0, 6)), coat(rng, mottled(256, 512, count), some(count)))
    for k in range(6):
        z = np.linspace(0, 1, 60)
        radius = 0.09 * (1.1 + np.sin(2 * np.pi * (z * rng.uniform(0.5, 1.2) + rng.random()))) * (z < 0.99) + 0.01
        vase = mesh.lathe(np.stack([radius, z * rng.uniform(0.25, 0.6)], 1))
        bands = texture.mix((np.arange(512)[:, None] // rng.integers(15, 60) % 2) * np.ones((1, 64)) * 0.95)
        place = (rng.uniform(-1.2, 1.2), rng.uniform(-0.2, 0.6), 0.0)
        scene[f"vase{k}"] = mesh.shape(vase.move(place), coat(rng, bands, some(2)))
    from .foliage import leaf_atlas, leaves

    centres = np.array([rng.uniform(-1.2, 1.2), 0.7, 0.75]) + rng.normal(0, 1, (500, 3)) * [0.28, 0.15, 0.25]
    kinds = [str(n) for n in rng.choice([n for n in every if n.startswith("leaf")], 6, replace=False)]
    scene["plant"] = mesh.shape(leaves(centres, rng.uniform(0.08, 0.2, 500), rng), coat(rng, leaf_atlas(seed), kinds))
    import mitsuba as mi

    t = mi.ScalarTransform4f()
    for k, (at, size, cd_m2) in enumerate((((-2.5, -1.5, 2.6), 0.7, 3000.0), ((1.2, -1.0, 2.9), 0.25, 9000.0), ((0.2, 1.0, 2.8), 0.12, 6000.0))):
        look = t.look_at(list(at), [0, 0.2, 0.3], [0.1, 0.3, 1]).scale([size, size, 1])
        scene[f"lamp{k}"] = {"type": "rectangle", "to_world": look, "emitter": m.lamp("E", cd_m2)}
    return scene, {"fov": 33.0, "origin": [rng.uniform(-0.6, 0.3), -2.9, 1.25], "target": [0.0, 0.2, 0.38], "aperture": 0.004}
