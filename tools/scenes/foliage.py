"""A garden in sunshine: a tree, a hedge, flowers, grass, a fence, a brick house, sky."""

from typing import Any

import numpy as np

from . import material as m
from . import mesh, texture
from .mesh import Mesh

LEAF = ["Lawn grass GDS91", "TCS 37", "TCS 43", "TCS 42", "TCS 35", "TCS 34"]
GRASS = ["Lawn grass GDS91", "TCS 42", "Grass_dry.8+.2green", "TCS 37"]
PETALS = ["TCS 5", "TCS 20", "TCS 32", "TCS 98", "TCS 80", "TCS 1", "TCS 22", "TCS 37"]


def leaf_atlas(seed: int, cells: int = 8, size: int = 96) -> np.ndarray:
    """A row of leaves with midrib, side veins, blotches and worn edges; shares of LEAF."""
    rng = np.random.default_rng(seed)
    out = []
    for c in range(cells):
        v, u = np.meshgrid(np.linspace(0, 1, size), np.linspace(-1, 1, size), indexing="ij")
        rib = np.exp(-((u / 0.06) ** 2))
        side = 0.6 * np.exp(-(((np.abs(((v - 0.6 * np.abs(u)) * 9) % 1 - 0.5)) / 0.09) ** 2))
        vein = np.clip(rib + side, 0, 1) * 0.55
        blotch = texture.ramp(texture.noise(size, size, seed * 100 + c, 1.2, 2), 0.4, 1.6)
        young = np.full(v.shape, rng.beta(1.0, 3.0))
        yellow = texture.ramp(np.abs(u) + 0.3 * texture.noise(size, size, seed * 100 + c + 50, 1.4, 2), 0.9, 1.6) * rng.random() ** 2
        dark = 0.5 * blotch * rng.random()
        out.append(texture.mix(vein * 0.5, young * 0.8, vein, dark, yellow))
    return np.concatenate(out, axis=1)


def leaves(centres: np.ndarray, length: np.ndarray, rng: np.random.Generator, cells: int = 8, droop: float = 0.6, up: float = 0.6) -> Mesh:
    """Folded, bent leaves of eight triangles at given places, each with a cell of the atlas."""
    n = len(centres)
    t = np.array([0.0, 0.28, 0.62, 1.0])
    half = np.array([0.03, 0.27, 0.24, 0.0])
    azimuth = rng.uniform(0, 2 * np.pi, n)
    along = np.stack([np.cos(azimuth), np.sin(azimuth), rng.normal(-droop, 0.35, n)], 1)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    normal = np.stack([rng.normal(0, 0.6, n), rng.normal(0, 0.6, n), np.full(n, up)], 1)
    across = np.cross(along, normal)
    across /= np.linalg.norm(across, axis=1, keepdims=True) + 1e-9
    normal = np.cross(across, along)
    bend = rng.uniform(0.05, 0.35, n)
    fold = rng.uniform(0.1, 0.5, n)
    verts, uvs = [], []
    cell = rng.integers(0, cells, n)
    for k in range(4):
        mid = centres + length[:, None] * (t[k] * along - (bend * t[k] ** 2)[:, None] * normal)
        for side in (-1.0, 0.0, 1.0):
            lift = fold * half[k] * abs(side)
            verts.append(mid + length[:, None] * (side * half[k] * across + lift[:, None] * normal))
            uvs.append(np.stack([(cell + 0.5 + 0.47 * side * min(1.0, half[k] / 0.27)) / cells, np.full(n, 0.03 + 0.94 * t[k])], 1))
    faces = []
    for k in range(3):
        for s in range(2):
            a, b = 3 * k + s, 3 * k + s + 1
            faces += [[a, b, b + 3], [a, b + 3, a + 3]]
    order = np.arange(n)[:, None, None] * 12 + np.array(faces)[None]
    return Mesh(np.stack(verts, 1).reshape(-1, 3), order.reshape(-1, 3), np.stack(uvs, 1).reshape(-1, 2))


def branch(
    start: np.ndarray,
    direction: np.ndarray,
    length: float,
    radius: float,
    level: int,
    rng: np.random.Generator,
    tubes: list[Mesh],
    tips: list[np.ndarray],
) -> None:
    """Branches that bend, thin and fork; tips collects points that carry leaves."""
    steps = 9
    points = [start]
    d = direction / np.linalg.norm(direction)
    for _ in range(steps):
        d = d + rng.normal(0, 0.13, 3) + np.array([0, 0, 0.05])
        d /= np.linalg.norm(d)
        points.append(points[-1] + d * length / steps)
    path = np.array(points)
    tubes.append(mesh.tube(path, np.linspace(radius, radius * 0.55, len(path)), 14 if level == 0 else 7))
    if level >= 2:
        tips.extend(path[3:])
    if level == 4:
        return
    for _ in range(5 if level else 7):
        k = int(rng.integers(4 if level else 5, steps + 1))
        a = rng.normal(0, 1, 3)
        side = np.cross(d, a)
        side /= np.linalg.norm(side)
        branch(path[k], d * 0.55 + side * rng.uniform(0.5, 1.0), length * rng.uniform(0.5, 0.72), radius * 0.5, level + 1, rng, tubes, tips)


def blades(count: int, rng: np.random.Generator, low: tuple[float, float], high: tuple[float, float], tall: float) -> Mesh:
    """Blades of grass: bent ribbons of five triangles."""
    x, y = rng.uniform(low[0], high[0], count), rng.uniform(low[1], high[1], count)
    clump = np.sin(x * 3.1 + np.sin(y * 2.3)) * np.cos(y * 2.7)
    h = tall * rng.gamma(6, 1 / 6, count) * (1 + 0.3 * clump)
    w = h * rng.uniform(0.03, 0.06, count)
    a, lean = rng.uniform(0, 2 * np.pi, count), rng.gamma(2, 0.18, count)
    side = np.stack([np.cos(a), np.sin(a), np.zeros(count)], 1)
    out = np.stack([-np.sin(a), np.cos(a), np.zeros(count)], 1)
    base = np.stack([x, y, np.zeros(count)], 1)
    verts, uvs = [], []
    tint = rng.random(count)
    for t, f in ((0.0, 1.0), (0.4, 0.9), (0.75, 0.6), (1.0, 0.0)):
        p = base + (t * h)[:, None] * np.array([0, 0, 1.0]) + (lean * h * t * t)[:, None] * out
        for s in (-0.5, 0.5) if f > 0 else (0.0,):
            verts.append(p + (s * f * w)[:, None] * side)
            uvs.append(np.stack([tint, np.full(count, t * 0.95 + 0.02)], 1))
    faces = np.array([[0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4], [4, 5, 6]])
    order = np.arange(count)[:, None, None] * 7 + faces[None]
    return Mesh(np.stack(verts, 1).reshape(-1, 3), order.reshape(-1, 3), np.stack(uvs, 1).reshape(-1, 2))


def flowers(count: int, rng: np.random.Generator, low: tuple[float, float], high: tuple[float, float]) -> tuple[Mesh, Mesh]:
    """Heads of petals on stems; the first uv column chooses the colour of a flower."""
    heads, stems = [], []
    for _ in range(count):
        x, y, h = rng.uniform(low[0], high[0]), rng.uniform(low[1], high[1]), rng.uniform(0.28, 0.5)
        size, colour = rng.uniform(0.025, 0.045), int(rng.integers(0, 7))
        tilt = mesh.rotation_z(rng.uniform(0, 6.3)) @ mesh.rotation_x(rng.uniform(0.3, 1.3))
        petals = int(rng.integers(6, 14))
        for p in range(petals):
            r = np.linspace(0.1, 1, 6)[:, None]
            w = (np.sin(np.pi * r**0.8 * 0.93) * 0.30 + 0.02) * np.linspace(-1, 1, 5)[None]
            z = 0.35 * r**2 * (p % 2 + 0.6) - 0.5 * w**2 + 0.04 * np.sin(9 * r)
            g = mesh.grid(np.stack([np.broadcast_to(r, w.shape), w, z + 0 * w], 2))
            g = g.turn(tilt @ mesh.rotation_z(2 * np.pi * p / petals + rng.normal(0, 0.06)))
            g.uv[:, 0] = (colour + 0.1 + 0.8 * g.uv[:, 0]) / 8
            heads.append(g.move((x, y, h), size))
        core = mesh.sphere(9, 16).move((0, 0, 0.05), (0.22, 0.22, 0.14)).turn(tilt)
        core.uv[:, 0] = 7.5 / 8
        heads.append(core.move((x, y, h), size))
        bow = rng.normal(0, 0.03, 2)
        t = np.linspace(0, 1, 6)[:, None]
        stems.append(mesh.tube(np.concatenate([x + bow[0] * t * (1 - t), y + bow[1] * t * (1 - t), h * t], 1), np.full(6, 0.003), 5))
    return mesh.merge(heads), mesh.merge(stems)


def petal_atlas(size: int = 48) -> np.ndarray:
    """Seven colours of petals with veins, and the yellow core."""
    shares = np.zeros((size, 8 * size, 8), np.float32)
    v, u = np.meshgrid(np.linspace(0, 1, size), np.linspace(-1, 1, size), indexing="ij")
    vein = 0.25 * (0.5 + 0.5 * np.cos(u * 22)) * (1 - v) + 0.35 * np.exp(-v * 6)
    for c in range(7):
        cell = slice(c * size, (c + 1) * size)
        shares[:, cell, c] = 1 - vein
        shares[:, cell, 2 if c != 2 else 6] += vein
    grain = texture.ramp(texture.noise(size, size, 3, 0.5, 4), -1, 1)
    shares[:, 7 * size :, 6], shares[:, 7 * size :, 1] = grain, 1 - grain
    return shares


def fence(rng: np.random.Generator) -> Mesh:
    """Weathered pickets; each has its own part of the texture of wood."""
    parts = []
    for i, x in enumerate(np.arange(-4.4, 0.2, 0.135)):
        h, u = 0.98 + rng.normal(0, 0.015), rng.random()
        p = mesh.box((x, 5.0, 0.02), (x + 0.095, 5.022, h), [(u, 0, u + 0.08, 1)] * 6)
        lean = rng.normal(0, 0.012)
        p.vertices[:, 0] += lean * p.vertices[:, 2]
        top = np.isclose(p.vertices[:, 2], h)
        p.vertices[top, 0] = x + 0.0475 + (p.vertices[top, 0] - x - 0.0475) * 0.45
        parts.append(p)
    for z in (0.28, 0.75):
        parts.append(mesh.box((-4.5, 5.022, z), (0.3, 5.06, z + 0.075), [(0, 0.1, 0.08, 3.0)] * 6))
    return mesh.merge(parts)


def wood(seed: int) -> np.ndarray:
    """Grain along v: fresh, weathered, mossy, grey."""
    grain = texture.stretched(512, 1024, seed, 0.03, 1.1, 2)
    moss = texture.ramp(texture.noise(512, 1024, seed + 1, 1.3, 2) - 1.2 * np.linspace(-1, 1, 512)[:, None], 0.6, 2.2)
    return texture.mix(texture.ramp(grain, -1.2, 1.0), 0.8 * texture.ramp(texture.noise(512, 1024, seed + 2, 1.5, 2), -0.5, 1.5), 0.7 * moss)


def build() -> tuple[dict[str, Any], dict[str, Any]]:
    """The scene and its camera."""
    rng = np.random.default_rng(11)
    scene: dict[str, Any] = {"type": "scene"}
    scene["sky"] = {"type": "sunsky", "sun_direction": [-0.62, -0.58, 0.62], "turbidity": 3.2, "sun_scale": 1.0, "sky_scale": 1.0, "albedo": 0.15}
    soil = texture.mix(texture.ramp(texture.noise(1024, 1024, 1, 1.1, 4), -1, 1), 0.7 * texture.ramp(texture.noise(1024, 1024, 2, 1.3, 3), -0.2, 1.4))
    scene["ground"] = mesh.shape(
        mesh.quad((-60, -10, 0), (120, 0, 0), (0, 140, 0)),
        m.diffuse(soil, ["Natural umber GDS809 (raw)", "Grass_dry.8+.2green", "Lawn grass GDS91"], 45.0),
    )
    lawn = np.stack([np.tile(np.linspace(0, 1, 64)[None], (64, 1)) ** 2 * k for k in (1, 1)], 2)
    tip = np.linspace(0, 1, 64)[:, None] ** 3 * np.ones((1, 64))
    tone = texture.mix(np.tile(rng.random(64)[None] * 0.8, (64, 1)), 0.6 * tip * np.tile(rng.random(64)[None] ** 2, (64, 1)), 0.5 * lawn[:, :, 0])
    near = blades(230000, rng, (-3.4, -1.6), (4.0, 5.2), 0.10)
    far = blades(200000, rng, (-10, 5.2), (12, 24), 0.16)
    scene["grass"] = mesh.shape(mesh.merge([near, far]), m.diffuse(tone, GRASS))
    tubes: list[Mesh] = []
    tips: list[np.ndarray] = []
    branch(np.array([2.9, 6.2, 0.0]), np.array([-0.05, 0.0, 1.0]), 2.0, 0.17, 0, rng, tubes, tips)
    bark = texture.mix(
        texture.ramp(texture.stretched(512, 256, 7, 0.15, 1.0, 3), -0.6, 0.8), 0.5 * texture.ramp(texture.noise(512, 256, 8, 1.2, 3), 0.6, 1.6)
    )
    scene["branches"] = mesh.shape(mesh.merge(tubes), m.diffuse(bark, ["Natural umber GDS809 (raw)", "Cedar Shake GDS361 HiWeather", "TCS 35"]))
    at = np.array(tips)
    at = at[rng.integers(0, len(at), 62000)] + rng.normal(0, 0.055, (62000, 3))
    crown = leaves(at, rng.gamma(12, 0.085 / 12, len(at)), rng)
    green = m.plastic(leaf_atlas(1), LEAF, 0.35)
    scene["leaves"] = mesh.shape(crown, green, False)
    # Hedge on the right and a bush in front on the left, both shells of leaves about rounded solids.
    n = 60000
    a, h = rng.uniform(0, 2 * np.pi, n), rng.uniform(-0.15, 1, n)
    lump = 1 + 0.10 * np.sin(5 * a + 4 * h) + 0.07 * np.sin(11 * a - 7 * h)
    r = np.sqrt(np.clip(1 - np.maximum(h, 0) ** 2, 0, 1)) * lump * rng.uniform(0.82, 1.03, n)
    bush = np.stack([-2.55 + 0.75 * r * np.cos(a), 1.9 + 0.55 * r * np.sin(a), 0.12 + 0.85 * np.maximum(h, 0) * lump], 1)
    scene["bush"] = mesh.shape(
        leaves(bush, rng.gamma(14, 0.055 / 14, n), rng, up=1.0),
        m.plastic(leaf_atlas(2), [LEAF[1], LEAF[0], "TCS 34", LEAF[2], "TCS 28", "TCS 32"], 0.25),
        False,
    )
    n = 90000
    x, y, z = rng.uniform(0.6, 14, n), 11.0 + rng.uniform(-0.5, 0.1, n), 1.5 * rng.random(n) ** 0.7
    y += 0.18 * np.sin(x * 2.2 + 3 * z)
    scene["hedge"] = mesh.shape(
        leaves(np.stack([x, y, z], 1), rng.gamma(12, 0.075 / 12, n), rng),
        m.diffuse(leaf_atlas(3), ["TCS 35", LEAF[0], "TCS 37", "TCS 28", LEAF[4], LEAF[2]]),
        False,
    )
    parts = []
    for k in range(26):
        cx, cy, w, tall = rng.uniform(-40, 45), rng.uniform(38, 75), rng.uniform(2.5, 5), rng.uniform(5, 10)
        n = 5200
        d = rng.normal(0, 1, (n, 3))
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        rr = rng.uniform(0.75, 1.05, n)[:, None] * (1 + 0.22 * np.sin(4 * d[:, :1] * 3 + 5 * d[:, 2:]))
        parts.append(leaves(np.array([cx, cy, tall * 0.52]) + d * rr * [w, w, tall * 0.5], np.full(n, 0.42) * rng.uniform(0.6, 1.4, n), rng))
    scene["wood"] = mesh.shape(mesh.merge(parts), m.diffuse(leaf_atlas(4), ["TCS 35", LEAF[0], "TCS 28", LEAF[3], LEAF[4], "TCS 34"]), False)
    heads, stems = flowers(170, rng, (-1.9, 1.4), (3.3, 3.3))
    scene["petals"] = mesh.shape(heads, m.diffuse(petal_atlas(), PETALS))
    scene["stems"] = mesh.shape(stems, m.diffuse(None, ["TCS 42"]))
    low = np.stack([rng.uniform(-1.9, 3.3, 16000), rng.uniform(1.4, 3.4, 16000), rng.uniform(0.02, 0.3, 16000)], 1)
    scene["bed"] = mesh.shape(leaves(low, rng.gamma(10, 0.06 / 10, 16000), rng, droop=-0.2), green, False)
    scene["fence"] = mesh.shape(
        fence(rng),
        m.diffuse(
            wood(5), ["Cedar Shake GDS359 MedWeathr", "Cedar Shake GDS361 HiWeather", "Wood Beam GDS363 Nw Pine 2X4", "Cedar Shake GDS360 H Weamoss"]
        ),
        False,
    )
    joint, each = texture.bricks(1024, 1024, 12, 30, 0.11, 9)
    wall = texture.mix(each, 0.7 * texture.ramp(texture.noise(1024, 1024, 10, 1.0, 6), 0, 1.6), joint)
    brick = m.diffuse(
        wall, ["Brick GDS349 Paving Red", "Brick GDS350 Dk Red Building", "Brick GDS353 Building MedRed", "Cinder Block GDS356 Lg Grey"]
    )
    house = mesh.box((-9.5, 12.0, 0), (-3.0, 18.0, 3.4), [(0, 0, 2.7, 1.4), (0, 0, 2.5, 1.4)] + [(0, 0, 2, 1)] * 4)
    scene["house"] = mesh.shape(house, brick, False)
    roof = mesh.merge(
        [
            mesh.quad((-9.9, 11.6, 3.35), (7.3, 0, 0), (0, 3.4, 2.2), (0, 0, 3, 1)),
            mesh.quad((-9.9, 18.4, 3.35), (7.3, 0, 0), (0, -3.4, 2.2), (0, 0, 3, 1)),
            Mesh(np.array([[-3.0, 12.0, 3.4], [-3.0, 18.0, 3.4], [-3.0, 15.0, 5.35]]), np.array([[0, 1, 2]]), np.array([[0, 0], [1, 0], [0.5, 1]])),
        ]
    )
    joint, each = texture.bricks(512, 512, 14, 12, 0.10, 12)
    scene["roof"] = mesh.shape(
        roof, m.diffuse(texture.mix(each, 0.75 * joint), ["Terra Pozzuoli GDS806", "Venetian red GDS783", "Natural umber GDS809 (raw)"]), False
    )
    white = m.plastic(None, ["Plastic Vinyl GDS372 White"], 0.2)
    frames, panes = [], []
    for x0 in (-7.9, -5.2):
        frames += [
            mesh.box((x0 - 0.08, 11.93, 1.0), (x0 + 1.18, 12.02, 1.08)),
            mesh.box((x0 - 0.08, 11.93, 2.5), (x0 + 1.18, 12.02, 2.58)),
            mesh.box((x0 - 0.08, 11.93, 1.0), (x0, 12.02, 2.58)),
            mesh.box((x0 + 1.1, 11.93, 1.0), (x0 + 1.18, 12.02, 2.58)),
            mesh.box((x0 + 0.53, 11.94, 1.0), (x0 + 0.57, 12.02, 2.58)),
            mesh.box((x0, 11.94, 1.9), (x0 + 1.1, 12.02, 1.94)),
        ]
        panes.append(mesh.quad((x0, 11.985, 1.08), (1.1, 0, 0), (0, 0, 1.42)))
    scene["frames"] = mesh.shape(mesh.merge(frames), white, False)
    scene["panes"] = mesh.shape(mesh.merge(panes), m.plastic(None, ["Plastic HDPE GDS351 BlkSheet"], 0.02), False)
    return scene, {"origin": [0.1, -2.6, 1.28], "target": [0.15, 5.0, 1.42], "fov": 58.0, "aperture": 0.008, "focus": 5.2}


NAME = "foliage"
TITLE = "Garden in sunshine"
WHITE: Any = "probe"
SUN = [-0.62, -0.58, 0.62]
DEPTH = 7
