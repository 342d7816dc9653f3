"""A street at night: sodium lamps, an LED lamp, neon signs, a lit shop window, wet asphalt, deep shade."""

from typing import Any

import mitsuba as mi
import numpy as np

from . import material as m
from . import mesh, spectra, texture
from .mesh import Mesh

# Strokes of capital letters on a 4 × 6 raster, for bent glass tubes.
STROKES = {
    "A": [[(0, 0), (0, 4), (1.2, 6), (2.8, 6), (4, 4), (4, 0)], [(0, 2.6), (4, 2.6)]],
    "B": [[(0, 0), (0, 6), (2.8, 6), (3.8, 5.2), (3.8, 4), (2.8, 3.2), (0, 3.2)], [(2.8, 3.2), (4, 2.3), (4, 0.9), (2.8, 0), (0, 0)]],
    "R": [[(0, 0), (0, 6), (2.8, 6), (4, 5.2), (4, 4), (2.8, 3.1), (0, 3.1)], [(1.6, 3.1), (4, 0)]],
    "H": [[(0, 0), (0, 6)], [(4, 0), (4, 6)], [(0, 3), (4, 3)]],
    "O": [[(1.2, 0), (0, 1.2), (0, 4.8), (1.2, 6), (2.8, 6), (4, 4.8), (4, 1.2), (2.8, 0), (1.2, 0)]],
    "T": [[(0, 6), (4, 6)], [(2, 6), (2, 0)]],
    "E": [[(4, 6), (0, 6), (0, 0), (4, 0)], [(0, 3), (3, 3)]],
    "L": [[(0, 6), (0, 0), (4, 0)]],
    "C": [[(4, 5), (2.9, 6), (1.2, 6), (0, 4.8), (0, 1.2), (1.2, 0), (2.9, 0), (4, 1)]],
    "F": [[(4, 6), (0, 6), (0, 0)], [(0, 3), (3, 3)]],
}


def sign(word: str, origin: np.ndarray, along: np.ndarray, up: np.ndarray, height: float, radius: float, step: np.ndarray | None = None) -> Mesh:
    """Letters of glass tube; `step` moves from letter to letter (along the word if absent)."""
    parts = []
    s = height / 6
    for k, letter in enumerate(word):
        at = origin + (along * (k * 5.6 * s) if step is None else step * k)
        for stroke in STROKES[letter]:
            p = np.array(stroke)
            length = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(p, axis=0).T))])
            t = np.linspace(0, length[-1], max(6, int(length[-1] * 4)))
            xy = np.stack([np.interp(t, length, p[:, k2]) for k2 in (0, 1)], 1)
            for _ in range(2):
                xy[1:-1] = (xy[:-2] + 2 * xy[1:-1] + xy[2:]) / 4
            parts.append(mesh.tube(at + s * (xy[:, :1] * along + xy[:, 1:] * up), np.full(len(xy), radius), 8))
    return mesh.merge(parts)


def facade(x: float, y0: float, y1: float, height: float, sign_x: float, rng: np.random.Generator, first: float) -> dict[str, list[Mesh]]:
    """A front along y at x, facing −sign_x … with windows: wall strips, reveals, frames, glass, sills."""
    out: dict[str, list[Mesh]] = {k: [] for k in ("wall", "frame", "glass", "sill", "lit", "curtain")}
    n = max(1, int((y1 - y0) / 2.1))
    bay = (y1 - y0) / n
    width, tall = 1.05, 1.65
    floors = np.arange(first, height - 2.2, 3.0)

    def wall(ya: float, yb: float, za: float, zb: float) -> None:
        o, e = ((x, yb, za), (0, ya - yb, 0)) if sign_x < 0 else ((x, ya, za), (0, yb - ya, 0))
        uv = (yb / 3.0, za / 3.0, ya / 3.0, zb / 3.0) if sign_x < 0 else (ya / 3.0, za / 3.0, yb / 3.0, zb / 3.0)
        out["wall"].append(mesh.quad(o, e, (0, 0, zb - za), uv))

    wall(y0, y1, 0 if first < 2 else first - 0.4, floors[0] if len(floors) else height)
    for f, z in enumerate(floors):
        z0, z1 = z, z + tall
        ztop = floors[f + 1] if f + 1 < len(floors) else height
        for b in range(n):
            a = y0 + b * bay
            ya, yb = a + (bay - width) / 2, a + (bay + width) / 2
            wall(a, ya, z0, z1)
            wall(yb, a + bay, z0, z1)
            depth = sign_x * 0.16
            for p, q in (((x, ya, z0), (0, 0, tall)), ((x, yb, z0), (0, 0, tall))):
                out["wall"].append(mesh.quad(p, (depth, 0, 0), q))
            for zz in (z0, z1):
                out["wall"].append(mesh.quad((x, ya, zz), (depth, 0, 0), (0, width, 0)))
            g = x + depth
            lit = rng.random()
            kind = "lit" if lit < 0.14 else "glass"
            if lit < 0.30:
                out["curtain"].append(
                    mesh.grid(
                        np.stack(
                            np.broadcast_arrays(
                                g + sign_x * (0.10 + 0.03 * np.sin(np.linspace(0, 40, 60)))[None],
                                np.linspace(ya, ya + 0.4 * width, 60)[None],
                                np.linspace(z0, z1, 3)[:, None],
                            ),
                            2,
                        )
                    )
                )
            out[kind].append(mesh.quad((g + (sign_x * 0.22 if kind == "lit" else 0), ya, z0), (0, width, 0), (0, 0, tall)))
            for c in (ya, (ya + yb) / 2 - 0.025, yb - 0.05):
                out["frame"].append(mesh.box((g - 0.03, c, z0), (g + 0.03, c + 0.05, z1)))
            for zz in (z0, z0 + 0.62 * tall, z1 - 0.05):
                out["frame"].append(mesh.box((g - 0.03, ya, zz), (g + 0.03, yb, zz + 0.05)))
            out["sill"].append(mesh.box((min(x, x - sign_x * 0.10), ya - 0.08, z0 - 0.09), (max(x, x - sign_x * 0.10), yb + 0.08, z0)))
        wall(y0, y1, z1, ztop)
    out["sill"].append(mesh.box((min(x, x - sign_x * 0.25), y0, height - 0.15), (max(x, x - sign_x * 0.25), y1, height)))
    return out


def car() -> dict[str, Mesh]:
    """A parked car: body swept from sections, windows, wheels, lamps. Length along y."""
    t = np.linspace(0, 1, 120)
    roof = np.interp(t, [0, 0.02, 0.06, 0.25, 0.37, 0.48, 0.75, 0.93, 0.98, 1.0], [0.50, 0.66, 0.76, 0.90, 1.38, 1.46, 1.44, 1.02, 0.90, 0.55])
    belt = np.interp(t, [0, 0.02, 0.08, 0.26, 0.5, 0.86, 0.97, 1.0], [0.48, 0.64, 0.72, 0.82, 0.87, 0.92, 0.88, 0.54])
    for _ in range(3):
        roof[1:-1] = (roof[:-2] + 2 * roof[1:-1] + roof[2:]) / 4
        belt[1:-1] = (belt[:-2] + 2 * belt[1:-1] + belt[2:]) / 4
    roof = np.maximum(roof, belt + 0.005)
    half = 0.86 * np.interp(t, [0, 0.05, 0.15, 0.85, 0.95, 1], [0.72, 0.92, 1, 1, 0.93, 0.76])
    s = np.linspace(0, 1, 25)
    lower, upper = [], []
    for k in range(len(t)):
        y = 4.3 * t[k]
        z = 0.22 + (belt[k] - 0.22) * s
        w = half[k] * (1 - 0.10 * (1 - s) ** 3 + 0.03 * np.sin(np.pi * s)) * (1 - 0.03 * s**6)
        left = np.stack([-w, np.full(25, y), z], 1)
        lower.append(np.concatenate([left, left[::-1] * [-1, 1, 1]]))
        zz = belt[k] + (roof[k] - belt[k]) * np.sin(np.linspace(0, np.pi / 2, 20))
        ww = half[k] * 0.97 * (1 - 0.22 * np.linspace(0, 1, 20) ** 1.5) * np.cos(np.linspace(0, np.pi / 2, 20)) ** 0.14
        top = np.stack([-ww, np.full(20, y), zz], 1)
        upper.append(np.concatenate([top, top[::-1] * [-1, 1, 1]]))
    body, cabin = mesh.grid(np.array(lower)), mesh.grid(np.array(upper))
    tyre = mesh.lathe(np.array([[0.20, -0.10], [0.29, -0.10], [0.32, -0.06], [0.32, 0.06], [0.29, 0.10], [0.20, 0.10]]), 48)
    rim = mesh.lathe(np.array([[0.20, 0.09], [0.18, 0.05], [0.06, 0.08], [0.0, 0.09]]), 24)
    rim.vertices[:, 2] += 0.02 * np.sin(5 * np.arctan2(rim.vertices[:, 1], rim.vertices[:, 0]))
    turn = np.array([[0, 0, -1.0], [0, 1, 0], [1, 0, 0]])
    tyres, rims = [], []
    for y in (0.78, 3.42):
        for side in (-1, 1):
            tyres.append(tyre.turn(turn).move((side * 0.76, y, 0.32)))
            rims.append(rim.turn(turn).move((side * 0.78, y, 0.32), (-side, 1, 1)))
    lamps = mesh.merge([mesh.box((sx * 0.58 - 0.17, -0.015, 0.58), (sx * 0.58 + 0.17, 0.06, 0.70)) for sx in (-1, 1)])
    plate = mesh.quad((-0.26, -0.03, 0.40), (0.52, 0, 0), (0, 0, 0.11))
    bumper = mesh.box((-0.74, -0.02, 0.30), (0.74, 0.25, 0.52))
    return {"body": body, "cabin": cabin, "tyres": mesh.merge(tyres), "rims": mesh.merge(rims), "lamps": lamps, "plate": plate, "bumper": bumper}


def poster(seed: int, words: list[tuple[str, float, float, int, int]]) -> np.ndarray:
    p = texture.Print(640, 448, 5, 0)
    rng = np.random.default_rng(seed)
    for _ in range(5):
        x, y, r = rng.random(), rng.uniform(0.2, 0.8), rng.uniform(0.1, 0.3)
        p.ellipse(x - r, y - r * 0.7, x + r, y + r * 0.7, int(rng.integers(1, 4)))
    for text, x, y, size, ink in words:
        p.text(x, y, text, size, ink, True, anchor="ma")
    for k in range(9):
        p.text(0.06, 0.80 + 0.02 * k, "Saturdays from 8 pm · tickets at the door and at the box office · line 4, stop Harbour", 11, 4)
    return p.shares()


def build() -> tuple[dict[str, Any], dict[str, Any]]:
    rng = np.random.default_rng(8)
    scene: dict[str, Any] = {"type": "scene"}
    # Glow of the town on haze: sodium light, three orders of magnitude below the lit road.
    scene["glow"] = {"type": "constant", "radiance": m.spectrum(spectra.radiance("HP2", 0.006))}
    grain = texture.ramp(texture.noise(2048, 2048, 1, 0.45, 60), -0.4, 1.2)
    worn = texture.ramp(texture.noise(2048, 2048, 2, 1.5, 2), -0.2, 1.2)
    v = np.linspace(0, 1, 2048)[:, None]
    u = np.linspace(0, 1, 2048)[None]
    crack = 1 - texture.ramp(np.abs(texture.noise(2048, 2048, 3, 1.6, 3)), 0.004, 0.02)
    line = (np.abs(u - 0.5) < 0.012) * ((v * 4) % 1 < 0.55) * texture.ramp(texture.noise(2048, 2048, 4, 0.7, 30), -1.6, -0.3)
    asphalt = texture.mix(0.5 * grain, 0.4 * worn, crack * 0.8, line)
    road_inks = [
        "Asphalt Tar GDS346 Blck Roof",
        "Concrete GDS375 Lt Gry Road",
        "Asphalt GDS376 Blck Road old",
        "Roofing Felt GDS377 Black",
        "Titanium dioxide GDS798 TiO2",
    ]
    puddle = texture.ramp(texture.noise(1024, 1024, 6, 1.7, 3) + 0.12 * texture.noise(1024, 1024, 7, 0.9, 40), 0.15, 0.75)
    road = {
        "type": "twosided",
        "bsdf": {
            "type": "blendbsdf",
            "weight": {"type": "bitmap", "raw": True, "bitmap": mi.Bitmap(puddle[:, :, None].astype(np.float32))},
            "dry": {
                "type": "roughplastic",
                "alpha": 0.28,
                "int_ior": 1.33,
                "distribution": "ggx",
                "diffuse_reflectance": m.texture(asphalt, road_inks),
            },
            "wet": {
                "type": "roughplastic",
                "alpha": 0.035,
                "int_ior": 1.33,
                "distribution": "ggx",
                "diffuse_reflectance": m.texture(asphalt, road_inks, 1.0, 0.5),
            },
        },
    }
    n = 260
    gx, gy = np.meshgrid(np.linspace(-3.2, 3.2, n), np.linspace(-4, 46, 2 * n))
    wave = np.random.default_rng(2)
    z = 0.003 * np.sin(gx * 9 + wave.normal(0, 1)) * np.cos(gy * 3.1) - 0.01 * gx**2 / 3
    scene["road"] = mesh.shape(mesh.grid(np.stack([gx, gy, z], 2), (1.0, 5.0)), road)
    joint, each = texture.bricks(1024, 1024, 8, 16, 0.06, 3)
    flags = m.plastic(
        texture.mix(each, 0.5 * texture.ramp(texture.noise(1024, 1024, 5, 0.9, 8), 0, 1.5), joint),
        ["Concrete WTC01-37A", "Cinder Block GDS356 Lg Grey", "Brick GDS355 Paving Dk Gry", "Asphalt GDS376 Blck Road old"],
        0.2,
    )
    walk = []
    for s in (-1, 1):
        x0, x1 = (-5.2, -3.2) if s < 0 else (3.2, 5.2)
        walk.append(mesh.box((x0, -4, -0.2), (x1, 46, 0.13), [(0, 0, 1, 0.1)] * 4 + [(0, 0, 1.2, 30), (0, 0, 1, 1)]))
        edge = -3.2 if s < 0 else 3.2
        walk.append(mesh.box((edge - 0.07, -4, -0.2), (edge + 0.07, 46, 0.145), [(0, 0, 40, 0.1)] * 6))
    scene["walk"] = mesh.shape(mesh.merge(walk), flags, False)
    joint, each = texture.bricks(1024, 1024, 12, 36, 0.11, 21)
    dirt = texture.ramp(texture.noise(1024, 1024, 22, 1.2, 3), -0.2, 1.8)
    brick = m.diffuse(
        texture.mix(each, 0.55 * dirt, joint),
        ["Brick GDS349 Paving Red", "Brick GDS350 Dk Red Building", "Brick GDS348 Pave DkBrwngrey", "Concrete GDS375 Lt Gry Road"],
    )
    render_ = m.diffuse(
        texture.mix(0.6 * dirt, 0.5 * texture.ramp(texture.noise(1024, 1024, 23, 0.6, 30), 0, 2)),
        ["TCS 30", "Concrete WTC01-37A", "Italian nat sienna GDS805"],
    )
    pink = m.diffuse(
        texture.mix(0.6 * dirt, 0.4 * texture.ramp(texture.noise(1024, 1024, 24, 0.6, 30), 0, 2)),
        ["TCS 15", "Brick GDS354 Building Lt Gry", "Terra Pozzuoli GDS806"],
    )
    blocks = [
        (-5.2, -4, 7.5, 11.5, -1, brick, 3.6),
        (-5.2, 7.5, 19, 10.0, -1, render_, 0.9),
        (-5.2, 19, 46, 12.5, -1, brick, 1.0),
        (5.2, -4, 9.5, 10.5, 1, pink, 3.6),
        (5.2, 9.5, 23, 12.0, 1, brick, 1.0),
        (5.2, 23, 46, 9.5, 1, render_, 1.0),
    ]
    common: dict[str, list[Mesh]] = {}
    for k, (x, y0, y1, h, s, bsdf, first) in enumerate(blocks):
        parts = facade(x, y0, y1, h, s, rng, first)
        scene[f"wall{k}"] = mesh.shape(mesh.merge(parts.pop("wall")), bsdf, False)
        for key, value in parts.items():
            common.setdefault(key, []).extend(value)
    scene["frames"] = mesh.shape(mesh.merge(common["frame"]), m.plastic(None, ["Painted Aluminum GDS333 LgGr"], 0.3), False)
    scene["sills"] = mesh.shape(mesh.merge(common["sill"]), m.diffuse(None, ["Concrete GDS375 Lt Gry Road"]), False)
    scene["glass"] = mesh.shape(mesh.merge(common["glass"]), m.plastic(None, ["Plastic PVC GDS338 White"], 0.01, gain=0.05), False)
    scene["curtain"] = mesh.shape(mesh.merge(common["curtain"]), m.diffuse(None, ["TCS 23"]))
    scene["rooms"] = mesh.shape(mesh.merge(common["lit"]), {"type": "diffuse"}, False, emitter=m.lamp("A", 22.0))
    # The end of the street.
    scene["end"] = mesh.shape(mesh.quad((-7, 46, -0.2), (14, 0, 0), (0, 0, 9), (0, 0, 5, 3)), brick, False)
    # Shop on the left: lit window with goods, door, sign; bar on the right with neon.
    goods = []
    shop_inks = ["TCS 5", "TCS 20", "TCS 29", "TCS 45", "TCS 64", "TCS 76", "TCS 90", "TCS 24"]
    for k in range(90):
        y, z = rng.uniform(1.2, 6.6), rng.choice([0.55, 1.05, 1.55, 2.05])
        w, h = rng.uniform(0.06, 0.16), rng.uniform(0.1, 0.34)
        ink = int(rng.integers(8))
        goods.append(mesh.box((-5.9 - rng.uniform(0.05, 0.35), y, z), (-5.75, y + w, z + h), [((ink + 0.1) / 8, 0, (ink + 0.9) / 8, 1)] * 6))
    atlas = np.repeat(np.eye(8, dtype=np.float32)[None], 32, 0)
    atlas = np.repeat(atlas, 8, 1)
    scene["goods"] = mesh.shape(mesh.merge(goods), m.plastic(atlas, shop_inks, 0.2), False)
    boards = [mesh.box((-6.3, 1.0, z - 0.03), (-5.7, 6.9, z)) for z in (0.55, 1.05, 1.55, 2.05)] + [
        mesh.quad((-6.35, 1.0, 0.3), (0, 6.0, 0), (0, 0, 2.9)),
        mesh.box((-6.4, 0.9, 3.05), (-5.2, 7.0, 3.2)),
        mesh.box((-6.4, 0.85, 0.1), (-5.2, 1.0, 3.2)),
        mesh.box((-6.4, 6.9, 0.1), (-5.2, 7.05, 3.2)),
        mesh.box((-5.35, 0.9, 0.1), (-5.2, 7.0, 0.5)),
    ]
    scene["shop"] = mesh.shape(mesh.merge(boards), m.diffuse(None, ["Plywood GDS365 Fresh Pine"]), False)
    scene["tubes"] = mesh.shape(
        mesh.merge([mesh.tube(np.stack([np.full(20, -5.5), np.linspace(1.3, 6.6, 20), np.full(20, 2.98)], 1), np.full(20, 0.02), 8)]),
        {"type": "diffuse"},
        emitter=m.lamp("FL3.12", 5000.0),
    )
    front = [mesh.box((-5.24, y, 0.1), (-5.16, y + 0.07, 3.1)) for y in (0.95, 2.9, 4.9, 6.85)] + [
        mesh.box((-5.3, -4, 0.1), (-5.2, 0.9, 3.2)),
        mesh.box((-5.3, 7.0, 0.1), (-5.2, 7.5, 3.2)),
    ]
    scene["front"] = mesh.shape(mesh.merge(front), m.plastic(None, ["Polyester Pile GDS435 DkGrn"], 0.1), False)
    board = texture.Print(192, 1536, 4, 0)
    board.text(0.5, 0.10, "BAKERY · FRUIT · NEWS", 128, 1, True, anchor="ma")
    board.rectangle(0.01, 0.04, 0.99, 0.08, 2)
    board.rectangle(0.01, 0.92, 0.99, 0.96, 2)
    scene["board"] = mesh.shape(
        mesh.quad((-5.13, 0.8, 3.2), (0, 6.4, 0), (0, 0, 0.55)),
        m.plastic(board.shares(), ["Prussian blue GDS802", "TCS 24", "Naples yellow GDS787", "TCS 44"], 0.15),
        False,
    )
    up, along = np.array([0, 0, 1.0]), np.array([0, -1.0, 0])
    scene["neon"] = mesh.shape(sign("BAR", np.array([4.98, 6.9, 3.35]), along, up, 0.62, 0.016), {"type": "diffuse"}, emitter=m.lamp("Neon", 1500.0))
    hotel = sign("HOTEL", np.array([4.05, 12.4, 7.1]), np.array([1.0, 0, 0]), up, 0.55, 0.02, step=np.array([0, 0, -0.75]))
    scene["hotel"] = mesh.shape(hotel, {"type": "diffuse"}, emitter=m.lamp("Neon", 1300.0))
    scene["hotelboard"] = mesh.shape(mesh.box((3.9, 12.45, 3.9), (4.6, 12.6, 7.9)), m.plastic(None, ["TCS 75"], 0.2), False)
    cafe = sign("CAFE", np.array([-5.05, 9.0, 3.1]), np.array([0, 1.0, 0]), up, 0.5, 0.016)
    scene["cafe"] = mesh.shape(cafe, {"type": "diffuse"}, emitter=m.lamp("Mercury", 900.0))
    ring = np.linspace(0, 2 * np.pi, 60)
    loop = mesh.tube(np.stack([np.full(60, 4.98), 5.95 + 1.35 * np.cos(ring), 3.66 + 0.55 * np.sin(ring)], 1), np.full(60, 0.014), 8)
    scene["loop"] = mesh.shape(loop, {"type": "diffuse"}, emitter=m.lamp("LED-RGB1", 260.0))
    door = [
        mesh.box((5.12, 5.2, 0.13), (5.2, 6.2, 2.5)),
        mesh.box((5.1, 4.9, 0.13), (5.25, 5.0, 2.9)),
        mesh.box((5.1, 6.4, 0.13), (5.25, 6.5, 2.9)),
        mesh.box((5.1, 1.0, 0.1), (5.2, 4.9, 0.9)),
        mesh.box((5.1, 1.0, 2.7), (5.2, 9.5, 3.2)),
        mesh.box((5.1, 6.5, 0.1), (5.2, 9.5, 2.9)),
        mesh.box((5.1, -4, 0.1), (5.2, 1.0, 3.2)),
    ]
    scene["bar"] = mesh.shape(mesh.merge(door), m.plastic(None, ["TCS 7"], 0.12), False)
    scene["barglass"] = mesh.shape(mesh.quad((5.16, 1.0, 0.9), (0, 3.9, 0), (0, 0, 1.8)), {"type": "diffuse"}, False, emitter=m.lamp("LED-B1", 14.0))
    bars = [mesh.box((5.10, y, 0.9), (5.17, y + 0.05, 2.7)) for y in np.linspace(1.0, 4.85, 5)] + [mesh.box((5.10, 1.0, 2.1), (5.17, 4.9, 2.16))]
    scene["bars"] = mesh.shape(mesh.merge(bars), m.plastic(None, ["TCS 7"], 0.12), False)
    for k, (y, words) in enumerate(
        [
            (7.0, [("JAZZ", 0.5, 0.08, 120, 4), ("QUARTET", 0.5, 0.3, 60, 1), ("12 MAY", 0.5, 0.6, 80, 3)]),
            (8.1, [("CIRCUS", 0.5, 0.1, 88, 2), ("GRAND OPENING", 0.5, 0.4, 40, 4)]),
        ]
    ):
        inks = [["TCS 29", "TCS 5", "TCS 76", "TCS 8", "TCS 44"], ["TCS 64", "TCS 20", "TCS 24", "TCS 97", "TCS 44"]][k]
        scene[f"poster{k}"] = mesh.shape(mesh.quad((5.085, y + 0.85, 1.0), (0, -0.85, 0), (0, 0, 1.25)), m.diffuse(poster(k, words), inks), False)
    # Lamp posts.
    posts, heads_hps = [], []
    for x, y in ((-3.6, 9.0), (3.6, 18.0), (-3.6, 27.0), (3.6, 36.0)):
        s = np.sign(-x)
        t = np.linspace(0, 1, 30)
        bow = np.stack(
            [
                x + s * 1.3 * np.clip((t - 0.75) / 0.25, 0, 1) ** 1.6,
                np.full(30, y),
                0.1 + 5.6 * np.minimum(t / 0.8, 1) + 0.5 * np.sin(np.clip((t - 0.75) / 0.25, 0, 1) * np.pi / 2),
            ],
            1,
        )
        posts.append(mesh.tube(bow, np.linspace(0.08, 0.04, 30), 12))
        posts.append(mesh.box((x + s * 1.2 - 0.02 - 0.2, y - 0.12, 6.17), (x + s * 1.2 + 0.45, y + 0.12, 6.27)))
        heads_hps.append(mesh.quad((x + s * 1.2 - 0.15, y - 0.09, 6.165), (0, 0.18, 0), (0.5, 0, 0)))
    scene["posts"] = mesh.shape(mesh.merge(posts), m.plastic(None, ["Painted Aluminum GDS333 LgGr"], 0.3))
    scene["sodium"] = mesh.shape(mesh.merge(heads_hps), {"type": "diffuse"}, False, emitter=m.lamp("HP1", 60000.0))
    scene["ledlamp"] = mesh.shape(
        mesh.quad((4.85, 0.2, 3.05), (0, 0.5, 0), (0.12, 0, 0)), {"type": "diffuse"}, False, emitter=m.lamp("LED-B5", 9000.0)
    )
    parts = car()
    paint = m.plastic(None, ["Plastic Pipe GDS344 Blue"], 0.03)
    place: dict[str, Any] = {"offset": (2.25, 3.4, 0.0)}
    scene["carbody"] = mesh.shape(parts["body"].move(**place), paint)
    scene["carcabin"] = mesh.shape(parts["cabin"].move(**place), m.plastic(None, ["Plastic HDPE GDS351 BlkSheet"], 0.015))
    scene["cartyres"] = mesh.shape(parts["tyres"].move(**place), m.plastic(None, ["Roofing Felt GDS377 Black"], 0.4))
    scene["carrims"] = mesh.shape(parts["rims"].move(**place), m.metal("Al", 0.15))
    scene["carlamps"] = mesh.shape(parts["lamps"].move(**place), m.metal("Al", 0.05), False)
    scene["carbumper"] = mesh.shape(parts["bumper"].move(**place), m.plastic(None, ["Plastic HDPE GDS351 BlkSheet"], 0.3), False)
    tag = texture.Print(96, 448, 3, 0)
    tag.text(0.5, 0.12, "KR · 4721 B", 66, 1, True, anchor="ma")
    scene["carplate"] = mesh.shape(
        parts["plate"].move((2.25, 3.365, 0.02)), m.plastic(tag.shares(), [("Plastic HDPE GDS384 Wht Opaq"), "TCS 44", "TCS 76"], 0.2), False
    )
    bins = [
        mesh.lathe(np.array([[0, 0], [0.24, 0], [0.29, 0.75], [0.31, 0.76], [0.31, 0.82], [0.25, 0.9], [0, 0.93]]), 40).move((-4.6, 7.6, 0.13)),
        mesh.lathe(np.array([[0, 0], [0.24, 0], [0.29, 0.75], [0.31, 0.76], [0.31, 0.82], [0.25, 0.9], [0, 0.93]]), 40).move((-4.62, 8.3, 0.13)),
    ]
    scene["bins"] = mesh.shape(mesh.merge(bins), m.plastic(None, ["Plastic Tarp GDS339 Green"], 0.2))
    crates = mesh.merge(
        [mesh.box((-4.9, 2.0 + 0.62 * k, 0.13 + 0.3 * j), (-4.5, 2.55 + 0.62 * k, 0.40 + 0.3 * j)) for k in range(3) for j in range(2)]
    )
    grainw = texture.mix(texture.ramp(texture.stretched(256, 256, 31, 0.04, 1.0), -1, 1))
    scene["crates"] = mesh.shape(crates, m.diffuse(grainw, ["Plywood GDS365 Fresh Pine", "Cedar Shake GDS359 MedWeathr"]), False)
    fruit = []
    for _i in range(170):
        fruit.append(mesh.sphere(10, 16).move((rng.uniform(-4.87, -4.53), rng.uniform(2.03, 3.75), rng.uniform(0.71, 0.77)), 0.042))
    scene["fruit"] = mesh.shape(mesh.merge(fruit), m.plastic(None, ["TCS 20"], 0.2))
    return scene, {"origin": [-0.55, -3.2, 1.62], "target": [-0.25, 8.0, 2.15], "fov": 60.0, "aperture": 0.004, "focus": 9.0}


NAME = "street"
TITLE = "Street at night with sodium, LED, fluorescent and neon lamps"
WHITE: Any = "LED-B3"
DEPTH = 6
PERCENTILE = 97.5
