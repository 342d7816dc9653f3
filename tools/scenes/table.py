"""A table under LED light: woven and knitted fabrics, fruit, bread, cheese, crockery."""

from typing import Any

import numpy as np

from . import material as m
from . import mesh, texture
from .mesh import Mesh


def cloth_height(x: np.ndarray, y: np.ndarray, seed: int, amount: float) -> np.ndarray:
    """Folds of a cloth on a table."""
    rng = np.random.default_rng(seed)
    z = np.zeros_like(x)
    for _ in range(7):
        a, f, p = rng.uniform(0, np.pi), rng.uniform(6, 22), rng.uniform(0, 6.3)
        w = np.sin((x * np.cos(a) + y * np.sin(a)) * f + p + 0.8 * np.sin(3 * x - 2 * y + p))
        z += np.maximum(w, 0) ** 3 * rng.uniform(0.2, 1) / 7
    return amount * z


def folded(width: float, depth: float, layers: int, thickness: float, seed: int) -> Mesh:
    """A stack of folded cloth: each layer turns over at its front edge."""
    rng = np.random.default_rng(seed)
    parts = []
    for k in range(layers):
        arc = np.linspace(-np.pi / 2, np.pi / 2, 24)
        r = thickness * 0.48
        path = np.concatenate(
            [
                np.stack([np.linspace(depth, 0, 40), np.full(40, -r)], 1),
                np.stack([-r * np.cos(arc), r * np.sin(arc)], 1),
                np.stack([np.linspace(0, depth, 40), np.full(40, r)], 1),
            ]
        )
        u = np.linspace(0, width, 120)[None]
        px, pz = path[:, 0][:, None], path[:, 1][:, None]
        sag = 0.12 * thickness * (np.sin(u * 21 + rng.uniform(0, 6)) + np.sin(u * 47 + rng.uniform(0, 6)) * 0.5)
        y = px + 0.003 * np.sin(u * 13 + k) + rng.normal(0, 0.004)
        z = pz + (k + 0.5) * thickness + sag * (px < depth * 0.9)
        parts.append(mesh.grid(np.stack(np.broadcast_arrays(u + rng.normal(0, 0.003), y, z), 2), (width * 4, 4 * 2 * depth)))
    return mesh.merge(parts)


def ball(seed: int, rough: float, squash: float, dimple: float, rows: int = 160) -> Mesh:
    """A fruit: sphere with broad lumps, fine pores and dimples at the poles."""
    s = mesh.sphere(rows, 2 * rows)
    v, u = s.uv[:, 1], s.uv[:, 0]
    n = texture.noise(256, 512, seed, 1.6, 2)
    fine = texture.noise(256, 512, seed + 1, 0.4, 40, 120)
    i = (np.clip((v * 255).astype(int), 0, 255), (u * 511).astype(int) % 512)
    edge = np.cos((v - 0.5) * np.pi)
    polar = np.arccos(np.clip(np.abs(s.vertices[:, 2]), 0, 1))
    r = (
        1
        + 0.015 * n[i] * edge
        + rough * fine[i] * edge
        - dimple * np.exp(-((polar / 0.33) ** 2)) * (s.vertices[:, 2] > 0)
        - 0.5 * dimple * np.exp(-((polar / 0.25) ** 2)) * (s.vertices[:, 2] < 0)
    )
    return Mesh(s.vertices * r[:, None] * [1, 1, squash], s.faces, s.uv)


def apple_skin(seed: int) -> np.ndarray:
    """Streaks of red over yellow-green, pale lenticels."""
    streak = texture.stretched(512, 512, seed, 6.0, 1.2, 2).T
    v, u = np.meshgrid(np.linspace(0, 1, 512), np.linspace(0, 1, 512), indexing="ij")
    blush = texture.ramp(0.55 * streak + 1.6 * np.sin(2 * np.pi * u + seed) + 0.5 * texture.noise(512, 512, seed + 2, 1.4, 2), -2.2, 0.7)
    rng = np.random.default_rng(seed)
    dots = np.zeros((512, 512))
    for _ in range(500):
        i, j = rng.integers(2, 510, 2)
        dots[i : i + 2, j : j + 2] = 0.6
    return texture.mix(0.8 * blush, 0.7 * blush * texture.ramp(streak, 0, 1.6), dots, 0.8 * np.exp(-(((1 - v) / 0.04) ** 2)))


def loaf() -> Mesh:
    """A loaf with slashed crust."""
    s = mesh.sphere(280, 560)
    x, y, z = s.vertices.T
    n = texture.noise(512, 1024, 71, 1.3, 4)
    f = texture.noise(512, 1024, 72, 0.6, 50, 200)
    i = (np.clip((s.uv[:, 1] * 511).astype(int), 0, 511), (s.uv[:, 0] * 1023).astype(int) % 1024)
    slash = (
        sum(np.exp(-(((x - c + 0.35 * y) / 0.035) ** 2)) for c in (-0.55, -0.2, 0.15, 0.5))
        * texture.ramp(z, 0.35, 0.7)
        * texture.ramp(-np.abs(y), -0.62, -0.45)
    )
    edge = np.sqrt(1 - np.clip(z, -1, 1) ** 2)
    r = 1 + 0.010 * n[i] * edge + 0.0025 * f[i] * edge - 0.10 * slash
    return Mesh(s.vertices * r[:, None] * [0.165, 0.082, 0.068], s.faces, s.uv)


def build() -> tuple[dict[str, Any], dict[str, Any]]:
    rng = np.random.default_rng(21)
    scene: dict[str, Any] = {"type": "scene"}
    # Tablecloth: checked linen; each thread of the weave is wider than a pixel near the camera.
    over, height = texture.weave(1024, 1024, 96, 1)
    v, u = np.meshgrid(np.arange(1024) / 1024, np.arange(1024) / 1024, indexing="ij")
    band_u, band_v = ((u * 4) % 1 < 0.30).astype(float), ((v * 4) % 1 < 0.30).astype(float)
    dyed = np.where(over > 0.5, band_u, band_v)
    shade = 0.75 * (1 - texture.ramp(height, 0.1, 0.75)) + 0.06 * np.clip(texture.noise(1024, 1024, 5, 0.6, 30), 0, 2)
    check = texture.mix(dyed, np.clip(shade, 0, 1))
    gx, gy = np.meshgrid(np.linspace(-0.75, 0.75, 700), np.linspace(-0.62, 0.55, 600))
    z = cloth_height(gx, gy, 3, 0.009)
    scene["cloth"] = mesh.shape(mesh.grid(np.stack([gx, gy, z], 2), (9.0, 7.0)), m.diffuse(check, ["Cotton Fabric GDS437 White", "TCS 75", "TCS 63"]))
    # Folded towels and napkins behind on the left.
    stacks = [
        ("Terrycloth Fabric GDS537 Yel", "Nylon Webbing GDS438 Flr Yel", 3, 0.030, 0.0),
        ("Nylon Fabric GDS431 Red RpSt", "TCS 8", 3, 0.018, 0.090),
        ("TCS 64", "TCS 65", 2, 0.022, 0.144),
        ("TCS 90", "TCS 89", 2, 0.020, 0.188),
        ("Nylon Fabric GDS432 Grn RpSt", "Polyester Pile GDS435 DkGrn", 2, 0.020, 0.228),
    ]
    for k, (a, b, layers, thick, z0) in enumerate(stacks):
        over, height = texture.weave(768, 768, (40, 64, 52, 48, 60)[k], 20 + k)
        stripe = ((v[:768, :768] * 1024 / 768 * 6) % 1 < 0.25) * (k in (2, 3)) * 1.0
        gap = 1 - texture.ramp(height, 0.05, 0.7)
        shares = texture.mix(np.clip(0.55 * gap + 0.35 * over + 0.08 * texture.noise(768, 768, 30 + k, 1.0, 4), 0, 1), stripe * 0.9, 0.5 * gap)
        f = folded(0.30 - 0.01 * k, 0.22, layers, thick, 40 + k).move((-0.60 + 0.008 * k, 0.16 + 0.006 * k, z0 + 0.002), 1.0, 0.0)
        scene[f"stack{k}"] = mesh.shape(f, m.diffuse(shares, [a, b, "Cotton Fabric GDS437 White", "Nylon Fabric GDS436 BlkCoatd"]))
    # Knitted cloth draped in front.
    rows, cols = 640, 640
    vv, uu = np.meshgrid(np.arange(rows) / rows * 26, np.arange(cols) / cols * 20, indexing="ij")
    du = (uu % 1) - 0.5
    stitch = np.cos(2 * np.pi * (vv + 0.55 * np.abs(du) * 2)) * 0.5 + 0.5
    knit = np.clip(1 - stitch * (1 - 0.5 * np.exp(-((du / 0.08) ** 2))), 0, 1)
    pattern = ((np.floor(uu) + np.floor(vv / 2)) % 6 < 2) * ((np.floor(vv) // 6) % 2 == 0) * 1.0
    fuzz = texture.noise(rows, cols, 50, 0.5, 60)
    kx, ky = np.meshgrid(np.linspace(0.22, 0.70, 420), np.linspace(-0.52, -0.12, 420))
    knit_z = 0.012 + cloth_height(kx * 1.7, ky * 1.7, 9, 0.045) + cloth_height(kx, ky, 12, 0.02)
    uvk = mesh.grid(np.stack([kx, ky, knit_z], 2), (3.0, 3.0))
    bump = knit[(np.mod(uvk.uv[:, 1], 1) * (rows - 1)).astype(int), (np.mod(uvk.uv[:, 0], 1) * (cols - 1)).astype(int)]
    uvk.vertices[:, 2] -= 0.0015 * bump
    scene["knit"] = mesh.shape(uvk, m.diffuse(texture.mix(pattern, np.clip(0.75 * knit + 0.1 * fuzz, 0, 1)), ["TCS 11", "TCS 23", "TCS 7"]))
    # Cutting board, loaf, slices, cheese, knife.
    grain = texture.stretched(512, 1024, 60, 0.03, 1.0, 2)
    board = m.plastic(
        texture.mix(texture.ramp(grain, -1.5, 1.2), 0.35 * texture.ramp(texture.noise(512, 1024, 61, 1.2, 3), 0, 2)),
        ["Plywood GDS365 Fresh Pine", "Cedar Shake GDS357 Fresh", "Italian burnt sienna GDS812"],
        0.3,
    )
    scene["board"] = mesh.shape(
        mesh.box((-0.30, -0.40, 0.012), (0.17, -0.10, 0.032), [(0, 0, 1, 0.06)] * 4 + [(0, 0, 1, 1)] * 2).move((0, 0, 0), 1.0, 0.10), board, False
    )
    crust = texture.mix(
        texture.ramp(texture.noise(512, 1024, 73, 1.3, 4), -1, 1.3),
        0.5 * texture.ramp(texture.noise(512, 1024, 74, 1.0, 12), 0.5, 1.9),
        0.5 * texture.ramp(texture.noise(512, 1024, 75, 0.9, 16), 0.6, 2),
    )
    scene["loaf"] = mesh.shape(
        loaf().move((-0.12, -0.19, 0.092), 1.0, 0.18),
        m.plastic(crust, ["TCS 19", "Italian nat sienna GDS805", "Italian burnt sienna GDS812", "TCS 23"], 0.4),
    )
    crumb = texture.mix(texture.ramp(texture.noise(384, 384, 76, 0.9, 10), 0.4, 1.3), 0.4 * texture.ramp(texture.noise(384, 384, 77, 0.6, 40), 0, 2))
    slices = []
    for k in range(3):
        a = np.linspace(0, 2 * np.pi, 80)
        ring = np.stack([0.080 * np.sign(np.cos(a)) * np.abs(np.cos(a)) ** 0.8, 0.062 * np.sign(np.sin(a)) * np.abs(np.sin(a)) ** 0.8], 1)
        r = np.linspace(0, 1, 24)[:, None]
        disc = mesh.grid(np.stack([r * ring[:, 0], r * ring[:, 1], 0.0016 * np.random.default_rng(k).normal(size=(24, 80)) * (r < 0.93)], 2))
        disc.uv = disc.vertices[:, :2] / 0.17 + 0.5
        slices.append(disc.turn(mesh.rotation_x(0.30 + 0.16 * k)).move((0.045 + 0.030 * k, -0.265 - 0.036 * k, 0.052 - 0.002 * k), 0.80, -0.4))
    scene["slices"] = mesh.shape(mesh.merge(slices), m.diffuse(crumb, ["TCS 23", "Naples yellow GDS787", "TCS 33"]), False)
    wedge = np.array([[0, 0, 0], [0.15, 0.03, 0], [0.14, -0.065, 0], [0, 0, 0.07], [0.15, 0.03, 0.07], [0.14, -0.065, 0.07]])
    cheese = []
    for q in ([0, 2, 5, 3], [0, 1, 4, 3], [3, 5, 4, 3], [1, 2, 5, 4]):
        p = wedge[q]
        s, t = np.meshgrid(np.linspace(0, 1, 160), np.linspace(0, 1, 110))
        surf = (
            ((1 - s) * (1 - t))[:, :, None] * p[0] + (s * (1 - t))[:, :, None] * p[1] + (s * t)[:, :, None] * p[2] + ((1 - s) * t)[:, :, None] * p[3]
        )
        if len(cheese) == 0:
            for cx, cz, r in ((0.04, 0.03, 0.011), (0.08, 0.05, 0.014), (0.11, 0.022, 0.010), (0.065, 0.016, 0.007), (0.125, 0.054, 0.007)):
                d = np.hypot(surf[:, :, 0] - cx, surf[:, :, 2] - cz) / r
                surf[:, :, 1] += np.sqrt(np.clip(1 - d**2, 0, 1)) * r * 0.9
        cheese.append(mesh.grid(surf, (1.0, 1.0)))
    pale = texture.mix(0.5 * texture.ramp(texture.noise(256, 256, 80, 1.1, 4), -1, 1))
    scene["cheese"] = mesh.shape(mesh.merge(cheese).move((-0.30, -0.335, 0.034), 1.0, 0.5), m.plastic(pale, ["TCS 29", "Naples yellow GDS787"], 0.25))
    blade = mesh.box((0, -0.0006, 0), (0.19, 0.0006, 0.028))
    blade.vertices[blade.vertices[:, 0] > 0.15, 2] *= 0.6
    scene["blade"] = mesh.shape(blade.turn(mesh.rotation_x(np.pi / 2 - 0.05)).move((-0.06, -0.445, 0.036), 1.0, 0.16), m.metal("Al", 0.08), False)
    scene["handle"] = mesh.shape(
        mesh.box((-0.11, -0.009, -0.004), (0.0, 0.009, 0.024)).turn(mesh.rotation_x(np.pi / 2 - 0.05)).move((-0.06, -0.455, 0.044), 1.0, 0.16),
        m.plastic(None, ["TCS 44"], 0.2),
        False,
    )
    # Bowl with fruit.
    glaze = m.plastic(texture.mix(0.5 * texture.ramp(texture.stretched(256, 512, 90, 0.05, 1.0, 2), 0, 2)), ["TCS 54", "TCS 64"], 0.04)
    bowl = np.array(
        [
            [0.0, 0.0],
            [0.05, 0.0],
            [0.055, 0.012],
            [0.09, 0.03],
            [0.125, 0.065],
            [0.14, 0.09],
            [0.144, 0.092],
            [0.140, 0.088],
            [0.12, 0.062],
            [0.085, 0.03],
            [0.0, 0.016],
        ]
    )
    fine = np.stack([np.interp(np.linspace(0, 10, 160), np.arange(11), bowl[:, k]) for k in (0, 1)], 1)
    scene["bowl"] = mesh.shape(mesh.lathe(fine, 160).move((0.24, 0.16, 0.006)), glaze)
    tones = 256
    peel = texture.mix(
        0.35 * texture.ramp(texture.noise(tones, 2 * tones, 95, 1.4, 2), -0.5, 1.5),
        0.5 * texture.ramp(texture.noise(tones, 2 * tones, 96, 0.4, 40, 110), 0.3, 1.8),
    )
    place = [
        ("orange", 0.17, 0.12, 0.075),
        ("apple", 0.29, 0.11, 0.078),
        ("apple", 0.21, 0.215, 0.08),
        ("orange", 0.30, 0.21, 0.077),
        ("lemon", 0.24, 0.155, 0.128),
        ("apple", 0.245, 0.075, 0.115),
        ("orange", 0.19, 0.175, 0.128),
    ]
    stems = []
    for k, (kind, x, y, zz) in enumerate(place):
        if kind == "orange":
            scene[f"orange{k}"] = mesh.shape(
                ball(100 + k, 0.0035, 0.95, 0.03).move((x, y, zz), 0.041, k), m.plastic(peel, ["TCS 20", "Cadmium orange 0 GDS786", "TCS 22"], 0.25)
            )
        elif kind == "apple":
            fruit = ball(100 + k, 0.0006, 0.92, 0.24).turn(mesh.rotation_x(0.5 * np.sin(k * 2.3)))
            scene[f"apple{k}"] = mesh.shape(
                fruit.move((x, y, zz), 0.040, k),
                m.plastic(apple_skin(200 + k), ["TCS 32", "TCS 12", "Venetian red GDS783", "TCS 33", "TCS 42"], 0.12),
            )
            p = np.stack(
                [np.full(8, x) + 0.004 * np.linspace(0, 1, 8) ** 2, np.full(8, y) - 0.012 * np.sin(k * 2.3), zz + 0.030 + np.linspace(0, 0.022, 8)], 1
            )
            stems.append(mesh.tube(p, np.linspace(0.0016, 0.0022, 8), 8))
        else:
            lemon = ball(150 + k, 0.003, 1.0, 0.0)
            lemon.vertices[:, 2] += 0.34 * np.sign(lemon.vertices[:, 2]) * np.abs(lemon.vertices[:, 2]) ** 9
            scene[f"lemon{k}"] = mesh.shape(
                lemon.turn(mesh.rotation_x(1.4)).move((x, y, zz + 0.02), 0.032, 0.6), m.plastic(peel, ["TCS 29", "TCS 31", "TCS 34"], 0.22)
            )
    scene["appstems"] = mesh.shape(mesh.merge(stems), m.diffuse(None, ["Burnt umber GDS811"]))
    # Tomatoes and grapes on the cloth, lettuce, plums.
    for k, (x, y) in enumerate(((0.02, -0.005), (0.085, -0.03), (0.055, 0.045))):
        t = ball(300 + k, 0.0003, 0.82, 0.12, 110)
        scene[f"tomato{k}"] = mesh.shape(
            t.move((x, y, 0.036), 0.033, 2.0 * k),
            m.plastic(texture.mix(0.4 * texture.ramp(texture.noise(256, 512, 310 + k, 1.5, 2), -1, 2)), ["Cadmium red 2 GDS778", "TCS 12"], 0.06),
        )
        star = []
        for p in range(5):
            s = np.linspace(0, 1, 9)[:, None]
            w = 0.0045 * (1 - s) ** 0.7 * np.linspace(-1, 1, 3)[None]
            g = np.stack([0.021 * s + 0 * w, w, 0.001 + 0.010 * s**3 - 0.006 * s + 0 * w], 2)
            star.append(mesh.grid(g).move((0, 0, 0), 1.0, 2 * np.pi * p / 5 + rng.normal(0, 0.1)))
        scene[f"star{k}"] = mesh.shape(mesh.merge(star).move((x, y, 0.0615)), m.diffuse(None, ["TCS 37"]))
    grapes = []
    for _ in range(46):
        d = rng.normal(0, 1, 3) * [0.042, 0.024, 0.013]
        grapes.append(
            mesh.sphere(28, 56).move((0.46 + d[0], -0.03 + d[1], 0.022 + abs(d[2]) * 1.5), rng.uniform(0.0105, 0.0128) * np.array([1, 1, 1.12]))
        )
    bloom = texture.mix(0.55 * texture.ramp(texture.noise(256, 256, 320, 1.0, 3), -0.4, 1.2))
    scene["grapes"] = mesh.shape(mesh.merge(grapes), m.plastic(bloom, ["TCS 89", "TCS 85"], 0.15))
    from .foliage import leaf_atlas, leaves

    pts = np.array([-0.36, -0.06, 0.02]) + rng.normal(0, 1, (120, 3)) * [0.045, 0.04, 0.008]
    pts[:, 2] = np.abs(pts[:, 2]) + 0.012
    scene["salad"] = mesh.shape(
        leaves(pts, rng.uniform(0.05, 0.085, 120), rng, droop=0.1, up=1.2),
        m.plastic(leaf_atlas(6), ["TCS 43", "TCS 42", "TCS 33", "TCS 37", "TCS 45", "TCS 32"], 0.25),
    )
    # Crockery: plates, mug, jar of honey; spoons.

    plate = np.array(
        [[0, 0.0], [0.06, 0.0], [0.065, 0.006], [0.09, 0.012], [0.125, 0.020], [0.127, 0.023], [0.09, 0.016], [0.062, 0.010], [0, 0.009]]
    )
    plate = np.stack([np.interp(np.linspace(0, 8, 120), np.arange(9), plate[:, k]) for k in (0, 1)], 1)
    ring = texture.mix(
        ((np.abs(np.linspace(0, 1, 512)[:, None] - 0.60) < 0.012) | (np.abs(np.linspace(0, 1, 512)[:, None] - 0.66) < 0.004)) * np.ones((1, 8))
    )
    scene["plates"] = mesh.shape(
        mesh.merge([mesh.lathe(plate, 128).move((-0.10, 0.14, 0.006 + 0.012 * k), 1.0, k) for k in range(4)]),
        m.plastic(ring, ["Plastic PVC GDS338 White", "Cobalt blue GDS790"], 0.03),
    )
    mug = np.array([[0, 0], [0.036, 0], [0.04, 0.004], [0.041, 0.095], [0.039, 0.096], [0.037, 0.09], [0.036, 0.075], [0.0, 0.075]])
    mug = np.stack([np.interp(np.linspace(0, 7, 100), np.arange(8), mug[:, k]) for k in (0, 1)], 1)
    a = np.linspace(-1.9, 1.9, 30)
    handle = mesh.tube(np.stack([0.040 + 0.026 * np.cos(a), 0 * a, 0.05 + 0.032 * np.sin(a)], 1), np.full(30, 0.0055), 14)
    scene["mug"] = mesh.shape(mesh.merge([mesh.lathe(mug, 96), handle]).move((0.52, 0.12, 0.006), 1.0, -0.8), m.plastic(None, ["TCS 5"], 0.04))
    mill = np.array(
        [
            [0, 0],
            [0.028, 0],
            [0.029, 0.01],
            [0.02, 0.03],
            [0.024, 0.07],
            [0.018, 0.11],
            [0.023, 0.13],
            [0.02, 0.155],
            [0.008, 0.165],
            [0.010, 0.175],
            [0, 0.18],
        ]
    )
    mill = np.stack([np.interp(np.linspace(0, 10, 140), np.arange(11), mill[:, k]) for k in (0, 1)], 1)
    for _ in range(4):
        mill[1:-1] = (mill[:-2] + 2 * mill[1:-1] + mill[2:]) / 4
    scene["mill"] = mesh.shape(
        mesh.lathe(mill, 80).move((0.44, 0.27, 0.006)),
        m.plastic(
            texture.mix(texture.ramp(texture.stretched(256, 256, 99, 0.05, 1.0).T, -1, 1)), ["Burnt umber GDS811", "Terra Pozzuoli GDS806"], 0.12
        ),
    )
    # Wall, curtain of heavy fabric behind, lamps.
    plaster = texture.mix(0.4 * texture.ramp(texture.noise(512, 512, 400, 1.1, 3), -1, 1.5))
    scene["wall"] = mesh.shape(mesh.quad((-2, 0.95, -0.6), (4, 0, 0), (0, 0, 2.6), (0, 0, 3, 2)), m.diffuse(plaster, ["TCS 69", "TCS 72"]), False)
    xs = np.linspace(-1.3, -0.15, 500)[None]
    zs = np.linspace(-0.4, 1.4, 40)[:, None]
    yy = 0.75 + 0.045 * np.sin(xs * 34 + 0.6 * np.sin(zs * 2)) + 0.015 * np.sin(xs * 91 + zs)
    over, height = texture.weave(768, 768, 70, 410)
    scene["curtain"] = mesh.shape(
        mesh.grid(np.stack(np.broadcast_arrays(xs, yy, zs), 2), (5.0, 6.0)),
        m.diffuse(
            texture.mix(0.7 * (1 - texture.ramp(height, 0, 0.8)), 0.25 * over),
            ["Nylon Webbing GDS428 OlvDrab", "TCS 39", "Burlap Fabric GDS430 Brown"],
        ),
    )
    scene["sidewall"] = mesh.shape(
        mesh.merge(
            [
                mesh.quad((2.0, -2, -0.6), (0, 3, 0), (0, 0, 2.6)),
                mesh.quad((-2, -2.2, 2.0), (4, 0, 0), (0, 3.2, 0)),
                mesh.quad((-2, -2.4, -0.6), (4, 0, 0), (0, 0, 2.6)),
            ]
        ),
        m.diffuse(None, ["TCS 36"]),
        False,
    )
    scene["key"] = mesh.shape(
        mesh.quad((-1.35, -0.25, 0.75), (0.45, 0.35, 0.0), (0.35, -0.30, 0.42)), {"type": "diffuse"}, False, emitter=m.lamp("LED-B2", 9000.0)
    )
    scene["fill"] = mesh.shape(mesh.quad((0.6, -1.9, 1.6), (0, 0.7, 0), (0.9, 0, 0)), {"type": "diffuse"}, False, emitter=m.lamp("LED-V1", 1500.0))
    return scene, {"origin": [0.03, -1.05, 0.56], "target": [0.0, -0.02, 0.055], "fov": 50.0, "aperture": 0.004, "focus": 1.06}


NAME = "table"
TITLE = "Fabrics and food on a table under LED light"
WHITE: Any = "LED-B2"
DEPTH = 7
