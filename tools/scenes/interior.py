"""A living room by day: window with garden, curtains, sofa, books, plant, pictures, a lamp that is on."""

from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from . import material as m
from . import mesh, spectra, texture
from .foliage import blades, leaf_atlas, leaves
from .mesh import Mesh

TITLES = [
    "OPTICS",
    "Travels in the North",
    "COLOUR",
    "The Sea",
    "Physics III",
    "Bread & Salt",
    "LIGHT",
    "A Year of Rain",
    "Atlas",
    "Botany",
    "SHADOWS",
    "Gardens",
    "Das Schloss",
    "Poems",
    "Measures",
    "The Lens",
    "HARBOUR",
    "Winter",
    "Maps",
    "Letters",
]
SPINES = ["TCS 8", "TCS 75", "TCS 49", "TCS 25", "TCS 90", "TCS 23", "TCS 44", "TCS 65", "TCS 13", "TCS 60", "TCS 5", "TCS 32"]


def pillow(width: float, height: float, thick: float, seed: int, rows: int = 90) -> Mesh:
    """A cushion: two swollen sheets with creases towards the corners."""
    u, v = np.meshgrid(np.linspace(-1, 1, rows), np.linspace(-1, 1, rows))
    swell = ((1 - u**4) * (1 - v**4)) ** 0.55
    n = texture.noise(rows, rows, seed, 1.9, 2)
    crease = 0.06 * np.sin(9 * np.arctan2(v, u)) * np.clip(np.hypot(u, v) - 0.5, 0, 1)
    pull = 1 - 0.07 * (1 - np.abs(u)) * v**2 - 0.07 * (1 - np.abs(v)) * u**2
    z = thick / 2 * swell * (1 + 0.10 * n + crease)
    up = np.stack([u * width / 2 * pull, v * height / 2 * pull, z], 2)
    down = up * [1, 1, -1]
    return mesh.merge([mesh.grid(up, (3, 3)), mesh.grid(down[:, ::-1], (3, 3))])


def soft_box(low: Any, high: Any, bulge: float, seed: int) -> Mesh:
    """An upholstered block: rounded, slightly swollen, with a seam."""
    s = mesh.sphere(140, 280)
    d = s.vertices
    p = np.sign(d) * np.abs(d) ** 0.28
    p /= np.maximum(np.abs(p).max(axis=1, keepdims=True), 1e-9) ** 0.85
    n = texture.noise(140, 280, seed, 1.9, 2)
    i = (np.clip((s.uv[:, 1] * 139).astype(int), 0, 139), (s.uv[:, 0] * 279).astype(int) % 280)
    low, high = np.asarray(low), np.asarray(high)
    v = (low + high) / 2 + p * (high - low) / 2 + bulge * d * (0.6 + 0.12 * n[i])[:, None]
    major = np.abs(d).argmax(axis=1)
    uv = np.where((major == 2)[:, None], v[:, [0, 1]], np.where((major == 1)[:, None], v[:, [0, 2]], v[:, [1, 2]])) * 3.0
    return Mesh(v, s.faces, uv)


def book_row(x0: float, x1: float, y: float, z: float, rng: np.random.Generator) -> list[tuple[Mesh, int]]:
    """Books on a board, each with a cell of the atlas of spines."""
    out = []
    x = x0
    while x < x1 - 0.05:
        w, h, d = rng.uniform(0.018, 0.05), rng.uniform(0.19, 0.27), rng.uniform(0.13, 0.17)
        cell = int(rng.integers(0, 24))
        u0 = cell / 24
        spine = (u0, 0, u0 + 1 / 24, 1)
        plain = (u0 + 0.002, 0.02, u0 + 0.004, 0.04)
        b = mesh.box((0, 0, 0), (w, d, h), [spine, plain, plain, plain, plain, plain])
        lean = rng.normal(0, 0.02) if rng.random() < 0.8 else 0.12
        b.vertices[:, 0] += lean * b.vertices[:, 2]
        out.append((b.move((x, y + rng.uniform(-0.01, 0.02), z)), cell))
        x += w + 0.001 + max(0.0, lean) * h
        if rng.random() < 0.05:
            x += rng.uniform(0.03, 0.10)
    return out


def spines() -> tuple[np.ndarray, list[str]]:
    """Twenty-four spines side by side, titles along the spine, in gold or white."""
    rng = np.random.default_rng(5)
    names = SPINES + ["TCS 24", "TCS 30"]
    p = texture.Print(1152, 24 * 160, len(names), 0)
    for k in range(24):
        ground = k % 12
        p.rectangle(k / 24, 0, (k + 1) / 24, 1, ground)
        light = 12 if rng.random() < 0.6 else 13
        for y in rng.uniform(0.03, 0.97, 4):
            p.rectangle(k / 24, y, (k + 1) / 24, y + 0.006, light)
        strip = Image.new("L", (1152, 160), 0)
        font = ImageFont.truetype(str(texture.FONTS / ("dejavu/DejaVuSerif-Bold.ttf" if k % 2 else "dejavu/DejaVuSans-Bold.ttf")), 88)
        ImageDraw.Draw(strip).text((576, 80), TITLES[k % len(TITLES)], fill=255, font=font, anchor="mm")
        whole = Image.new("L", (p.cols, p.rows), 0)
        whole.paste(strip.rotate(-90, expand=True), (k * 160, 0))
        p._apply(whole, light)
    return p.shares(), names


def painting(seed: int) -> np.ndarray:
    """Strokes of six paints over a ground: a landscape, more or less."""
    rng = np.random.default_rng(seed)
    p = texture.Print(480, 640, 6, 0)
    for k in range(420):
        y = rng.random()
        ink = int(np.clip(np.floor(6 * y + rng.normal(0, 0.9)), 0, 5))
        x, w, h = rng.random(), rng.uniform(0.02, 0.12), rng.uniform(0.006, 0.025)
        t = rng.normal(0, 0.02)
        p.polygon([(x, y), (x + w, y + t), (x + w, y + h + t), (x, y + h)], ink)
    return p.shares()


def build() -> tuple[dict[str, Any], dict[str, Any]]:
    rng = np.random.default_rng(33)
    scene: dict[str, Any] = {"type": "scene"}
    # Room: x −2.2 … 2.4, y −3.2 … 2.2 (wall with window at y = 2.2), z 0 … 2.6. Planks of oak along y.
    planks, cols = 12, 1536
    v, u = np.meshgrid(np.arange(1536) / 1536, np.arange(cols) / cols, indexing="ij")
    which = np.floor(u * planks).astype(int)
    cut = np.floor(v * 3 + np.random.default_rng(1).random(planks)[which]).astype(int)
    tone = np.random.default_rng(2).random((planks, 8))[which, cut % 8]
    grain = texture.stretched(1536, cols, 3, 0.04, 1.1, 3).T
    seam = texture.ramp(0.05 - np.minimum((u * planks) % 1, 1 - (u * planks) % 1), 0.0, 0.04)
    floor = texture.mix(texture.ramp(grain + tone, -1, 2), 0.7 * tone, seam)
    scene["floor"] = mesh.shape(
        mesh.quad((-2.2, -3.2, 0), (4.6, 0, 0), (0, 5.4, 0), (0, 0, 2.2, 1.4)),
        m.plastic(floor, ["Plywood GDS365 Fresh Pine", "Cedar Shake GDS357 Fresh", "Italian burnt sienna GDS812", "Burnt umber GDS811"], 0.16),
        False,
    )
    plaster = texture.mix(0.5 * texture.ramp(texture.noise(1024, 1024, 5, 0.8, 20), -0.5, 2))
    wall = m.diffuse(plaster, ["TCS 23", "TCS 33"], 2.0)
    side = m.diffuse(plaster, ["TCS 60", "TCS 61"], 2.0)
    wx0, wx1, wz0, wz1 = -1.30, 0.90, 0.62, 2.30
    parts = [
        mesh.quad((-2.2, 2.2, 0), (wx0 + 2.2, 0, 0), (0, 0, 2.6)),
        mesh.quad((wx1, 2.2, 0), (2.4 - wx1, 0, 0), (0, 0, 2.6)),
        mesh.quad((wx0, 2.2, 0), (wx1 - wx0, 0, 0), (0, 0, wz0)),
        mesh.quad((wx0, 2.2, wz1), (wx1 - wx0, 0, 0), (0, 0, 2.6 - wz1)),
        mesh.quad((-2.2, -3.2, 0), (4.6, 0, 0), (0, 0, 2.6)),
    ]
    scene["wall"] = mesh.shape(mesh.merge(parts), wall, False)
    scene["sides"] = mesh.shape(
        mesh.merge([mesh.quad((-2.2, -3.2, 0), (0, 5.4, 0), (0, 0, 2.6)), mesh.quad((2.4, -3.2, 0), (0, 5.4, 0), (0, 0, 2.6))]), side, False
    )
    scene["ceiling"] = mesh.shape(
        mesh.quad((-2.2, -3.2, 2.6), (4.6, 0, 0), (0, 5.4, 0)), m.diffuse(None, ["Titanium dioxide GDS798 TiO2"], gain=0.95), False
    )
    white = m.plastic(None, ["Plastic Vinyl GDS372 White"], 0.2)
    trim = [mesh.box((wx0 - 0.08, 2.12, wz0 - 0.10), (wx1 + 0.08, 2.45, wz0 - 0.06))]
    for a, b in ((wx0, wx0 + 0.06), (wx1 - 0.06, wx1), (-0.23, -0.17)):
        trim.append(mesh.box((a, 2.30, wz0 - 0.06), (b, 2.36, wz1)))
    for a, b in ((wz0 - 0.06, wz0), (wz1 - 0.06, wz1), (1.80, 1.84)):
        trim.append(mesh.box((wx0, 2.30, a), (wx1, 2.36, b)))
    trim += [
        mesh.box((wx0 - 0.01, 2.2, wz0 - 0.06), (wx0, 2.5, wz1)),
        mesh.box((wx1, 2.2, wz0 - 0.06), (wx1 + 0.01, 2.5, wz1)),
        mesh.box((wx0, 2.2, wz1), (wx1, 2.5, wz1 + 0.01)),
        mesh.box((-2.2, 2.18, 0), (2.4, 2.2, 0.09)),
        mesh.box((-2.2, -3.2, 0), (-2.18, 2.2, 0.09)),
        mesh.box((2.38, -3.2, 0), (2.4, 2.2, 0.09)),
    ]
    scene["trim"] = mesh.shape(mesh.merge(trim), white, False)
    # Heater below the window.
    t = np.linspace(0, 1, 340)[None]
    zz = np.linspace(0.12, 0.50, 6)[:, None]
    fins = mesh.grid(
        np.stack(
            np.broadcast_arrays(-0.9 + 1.4 * t, 2.10 - 0.018 * np.sign(np.sin(t * 2 * np.pi * 22)) * np.abs(np.sin(t * 2 * np.pi * 22)) ** 0.3, zz), 2
        )
    )
    scene["heater"] = mesh.shape(fins, white)
    # Curtains.
    over, height = texture.weave(768, 768, 80, 7)
    linen = texture.mix(np.clip(0.8 * (1 - texture.ramp(height, 0, 0.8)), 0, 1), 0.8 * ((v[:768, :768] * 2 * 5) % 1 < 0.12))
    drapes = []
    for a, b, k in ((-1.95, -1.27, 34.0), (0.86, 1.40, 34.0)):
        xs, zs = np.linspace(0, 1, 420)[None], np.linspace(0.03, 2.42, 60)[:, None]
        narrow = 1 - 0.12 * np.sin(np.pi * zs / 2.42)
        yy = 2.06 + 0.035 * np.sin(xs * k + 0.3 * np.sin(zs * 3)) + 0.012 * np.sin(xs * 2.7 * k + zs)
        drapes.append(mesh.grid(np.stack(np.broadcast_arrays(a + (b - a) * (0.5 + (xs - 0.5) * narrow), yy, zs), 2), (4.0, 8.0)))
    scene["drapes"] = mesh.shape(mesh.merge(drapes), m.diffuse(linen, ["TCS 32", "TCS 34", "TCS 8"]))
    scene["rod"] = mesh.shape(
        mesh.tube(np.array([[-1.9, 2.05, 2.45], [-0.2, 2.05, 2.45], [1.5, 2.05, 2.45]]), np.full(3, 0.014), 16), m.metal("Cu", 0.15)
    )
    # Rug.
    over, height = texture.weave(1024, 1024, 150, 9)
    vv, uu = np.meshgrid(np.linspace(-1, 1, 1024), np.linspace(-1, 1, 1024), indexing="ij")
    au, av = np.abs(uu), np.abs(vv)
    q = 64
    au, av = np.floor(au * q) / q, np.floor(av * q) / q
    field = (np.maximum(au, av) < 0.72).astype(float)
    medallion = ((au + av < 0.42) | ((np.abs(au - 0.5) + np.abs(av - 0.5)) < 0.12)).astype(float)
    border = (((au * 16).astype(int) + (av * 16).astype(int)) % 3 == 0) * (1 - field) * (np.maximum(au, av) < 0.93)
    lines_ = ((np.abs(np.maximum(au, av) - 0.74) < 0.012) | (np.abs(np.maximum(au, av) - 0.93) < 0.012)).astype(float)
    inner = (((au * 40).astype(int) % 7 == 0) & ((av * 40).astype(int) % 7 == 0)).astype(float) * field
    pile = np.clip(0.55 * (1 - texture.ramp(height, 0.1, 0.8)) + 0.10 * texture.noise(1024, 1024, 10, 0.7, 20), 0, 1)
    scene["rug"] = mesh.shape(
        mesh.box((-1.15, -1.35, 0.001), (1.25, 0.45, 0.014), [(0, 0, 1, 0.01)] * 4 + [(0, 0, 1, 1)] * 2),
        m.diffuse(
            texture.mix(field, medallion, border, inner, lines_, 0.7 * pile),
            [
                "Prussian blue GDS802",
                "Venetian red GDS783",
                "Cerulean blue GDS797",
                "Nylon Carpet GDS535 LtBrown",
                "Naples yellow GDS787",
                "TCS 23",
                "Polyester Pile GDS434 Blk",
            ],
        ),
        False,
    )
    # Sofa on the left wall, cushions, throw.
    over, height = texture.weave(640, 640, 60, 11)
    cloth = m.diffuse(texture.mix(np.clip(0.8 * (1 - texture.ramp(height, 0.05, 0.75)), 0, 1), 0.4 * over), ["TCS 71", "TCS 63", "TCS 69"])
    sofa = [
        soft_box((-2.1, -1.15, 0.16), (-1.25, 0.95, 0.42), 0.03, 1),
        soft_box((-2.18, -1.25, 0.30), (-1.92, 1.05, 0.86), 0.04, 2),
        soft_box((-2.15, -1.42, 0.14), (-1.22, -1.15, 0.60), 0.03, 3),
        soft_box((-2.15, 0.95, 0.14), (-1.22, 1.22, 0.60), 0.03, 4),
        soft_box((-1.95, -1.12, 0.38), (-1.20, -0.10, 0.54), 0.025, 5),
        soft_box((-1.95, -0.08, 0.38), (-1.20, 0.93, 0.54), 0.025, 6),
    ]
    scene["sofa"] = mesh.shape(mesh.merge(sofa), cloth)
    feet = mesh.merge([mesh.box((x, y, 0), (x + 0.05, y + 0.05, 0.16)) for x in (-2.1, -1.32) for y in (-1.38, 1.12)])
    scene["feet"] = mesh.shape(feet, m.plastic(None, ["Burnt umber GDS811"], 0.2), False)
    for k, (ink, accent, y, turn) in enumerate(
        (
            ("TCS 20", "TCS 24", -0.85, 0.15),
            ("TCS 8", "TCS 97", -0.42, -0.1),
            ("TCS 25", "Cotton Fabric GDS437 White", 0.62, 0.2),
            ("Nylon Fabric GDS432 Grn RpSt", "TCS 43", 0.22, -0.15),
        )
    ):
        gap = 1 - texture.ramp(height, 0.0, 0.7)
        pattern = [
            ((u[:640, :640] * 1536 / 640 * 8) % 1 < 0.3),
            (np.hypot((u[:640, :640] * 2.4 * 6) % 1 - 0.5, (v[:640, :640] * 2.4 * 6) % 1 - 0.5) < 0.28),
            ((u[:640, :640] * 2.4 * 5 + v[:640, :640] * 2.4 * 5) % 1 < 0.5),
            (np.floor(u[:640, :640] * 2.4 * 10) + np.floor(v[:640, :640] * 2.4 * 10)) % 2 == 0,
        ][k].astype(float)
        c = pillow(0.44, 0.44, 0.17, 50 + k).turn(mesh.rotation_x(np.pi / 2)).turn(mesh.rotation_z(np.pi / 2 + turn))
        tilt = np.array([[np.cos(-0.35), 0, np.sin(-0.35)], [0, 1, 0], [-np.sin(-0.35), 0, np.cos(-0.35)]])
        scene[f"cushion{k}"] = mesh.shape(
            c.turn(tilt).move((-1.72, y, 0.76)), m.diffuse(texture.mix(pattern, np.clip(0.5 * gap, 0, 1)), [ink, accent, "TCS 44"])
        )
    # Bookcase on the right wall side, against the back wall.
    wood = m.plastic(
        texture.mix(texture.ramp(texture.stretched(512, 512, 13, 0.04, 1.1), -1, 1)), ["Italian burnt sienna GDS812", "Burnt umber GDS811"], 0.15
    )
    case = (
        [mesh.box((1.47, 1.90, z), (2.36, 2.19, z + 0.022)) for z in (0.05, 0.42, 0.76, 1.08, 1.40, 1.74, 2.06)]
        + [mesh.box((x, 1.90, 0), (x + 0.022, 2.19, 2.08)) for x in (1.45, 2.36)]
        + [mesh.quad((1.47, 2.185, 0.05), (0.89, 0, 0), (0, 0, 2.0))]
    )
    scene["case"] = mesh.shape(mesh.merge(case), wood, False)
    books = []
    for z in (0.072, 0.442, 0.782, 1.102, 1.422, 1.762):
        books += [b for b, _ in book_row(1.48, 2.34 - 0.3 * rng.random(), 1.95, z, rng)]
    shares, names = spines()
    scene["books"] = mesh.shape(mesh.merge(books), m.plastic(shares, names, 0.3), False)
    # Pictures on the left wall and beside the window.
    frames = []
    for k, (y, z, w, h) in enumerate(((-0.55, 1.62, 0.70, 0.52), (0.45, 1.58, 0.55, 0.42))):
        inks = [["TCS 70", "TCS 60", "TCS 25", "TCS 42", "TCS 35", "TCS 13"], ["TCS 79", "TCS 1", "TCS 12", "TCS 77", "TCS 49", "TCS 44"]][k]
        scene[f"painting{k}"] = mesh.shape(
            mesh.quad((-2.18, y + w / 2, z - h / 2), (0, -w, 0), (0, 0, h), (1, 0, 0, 1)), m.plastic(painting(60 + k), inks, 0.2), False
        )
        for a, b in (
            ((-w / 2 - 0.04, -h / 2 - 0.04), (-w / 2, h / 2 + 0.04)),
            ((w / 2, -h / 2 - 0.04), (w / 2 + 0.04, h / 2 + 0.04)),
            ((-w / 2, -h / 2 - 0.04), (w / 2, -h / 2)),
            ((-w / 2, h / 2), (w / 2, h / 2 + 0.04)),
        ):
            frames.append(mesh.box((-2.2, y + a[0], z + a[1]), (-2.155, y + b[0], z + b[1])))
    scene["pframes"] = mesh.shape(mesh.merge(frames), m.metal("Cu", 0.25), False)
    # Low table with magazines, cup and fruit.
    top = mesh.lathe(np.array([[0, 0.40], [0.46, 0.40], [0.47, 0.41], [0.47, 0.42], [0.46, 0.43], [0.0, 0.43]]), 128)
    top.uv = top.vertices[:, :2] + 0.5
    legs = mesh.merge(
        [
            mesh.tube(np.array([[0.30 * np.cos(a), 0.30 * np.sin(a), 0.41], [0.38 * np.cos(a), 0.38 * np.sin(a), 0.0]]), np.array([0.02, 0.014]), 12)
            for a in (0.6, 2.2, 3.7, 5.3)
        ]
    )
    scene["lowtable"] = mesh.shape(
        mesh.merge([top, legs]).move((-0.10, -0.55, 0.014)),
        m.plastic(
            texture.mix(texture.ramp(texture.stretched(768, 768, 15, 0.04, 1.1, 2), -1, 1.2)),
            ["Plywood GDS365 Fresh Pine", "Terra Pozzuoli GDS806"],
            0.08,
        ),
        False,
    )
    mag = texture.Print(512, 384, 5, 0)
    mag.halftone(np.clip(0.5 + 0.3 * texture.noise(512, 384, 16, 1.8, 1), 0, 1), 1)
    mag.ellipse(0.2, 0.3, 0.8, 0.75, 2)
    mag.text(0.5, 0.03, "SPECTRUM", 62, 3, True, anchor="ma")
    for k in range(10):
        mag.text(0.05, 0.78 + 0.02 * k, "Filters and mosaics · the light of a north room · twelve lenses", 9, 4)
    scene["magazine"] = mesh.shape(
        mesh.box((-0.14, -0.11, 0), (0.14, 0.11, 0.012), [(0, 0, 1, 0.02)] * 4 + [(0, 0, 1, 1)] * 2).move((-0.22, -0.68, 0.445), 1.0, 0.35),
        m.plastic(mag.shares(), ["TCS 64", "TCS 20", "TCS 24", "Plastic HDPE GDS384 Wht Opaq", "TCS 44"], 0.1),
        False,
    )
    bowl = np.stack(
        [np.interp(np.linspace(0, 5, 60), np.arange(6), c) for c in ([0, 0.06, 0.10, 0.13, 0.125, 0.0], [0.0, 0.0, 0.03, 0.07, 0.068, 0.012])], 1
    )
    scene["bowl"] = mesh.shape(mesh.lathe(bowl, 80).move((0.08, -0.45, 0.444)), m.plastic(None, ["TCS 76"], 0.04))
    for k in range(5):
        scene[f"fruit{k}"] = mesh.shape(
            mesh.sphere(40, 80).move((0.08 + 0.05 * np.cos(k * 1.4), -0.45 + 0.05 * np.sin(k * 1.4), 0.505 + (0.035 if k == 4 else 0)), 0.038),
            m.plastic(None, ["TCS 20" if k % 2 else "TCS 42"], 0.2),
        )
    # Plant in a pot near the window; the leaves are large.
    pot = np.stack([np.interp(np.linspace(0, 4, 50), np.arange(5), c) for c in ([0, 0.13, 0.17, 0.175, 0.15], [0.0, 0.0, 0.30, 0.33, 0.31])], 1)
    scene["pot"] = mesh.shape(mesh.lathe(pot, 80).move((1.08, 1.55, 0)), m.plastic(None, ["Terra Pozzuoli GDS806"], 0.35))
    stalks, tips = [], []
    for k in range(26):
        a, reach, tall = rng.uniform(0, 6.3), rng.uniform(0.05, 0.36), rng.uniform(0.35, 0.95)
        t = np.linspace(0, 1, 10)
        path = np.stack([1.08 + reach * t**1.5 * np.cos(a), 1.55 + reach * t**1.5 * np.sin(a), 0.30 + tall * t], 1)
        stalks.append(mesh.tube(path, np.linspace(0.007, 0.003, 10), 8))
        tips.append(path[-1])
    tip = np.repeat(np.array(tips), 3, 0) + rng.normal(0, 0.02, (78, 3))
    scene["stalks"] = mesh.shape(mesh.merge(stalks), m.diffuse(None, ["TCS 37"]))
    scene["plant"] = mesh.shape(
        leaves(tip, rng.uniform(0.14, 0.30, len(tip)), rng, droop=0.15),
        m.plastic(leaf_atlas(8, 8, 256), ["Lawn grass GDS91", "TCS 43", "TCS 37", "TCS 42", "TCS 35", "TCS 34"], 0.15),
        False,
    )
    # Lamp on the bookcase side: stand and shade with a bulb.
    stand = mesh.tube(np.array([[1.05, -0.35, 0.02], [1.05, -0.35, 0.8], [1.05, -0.35, 1.45]]), np.array([0.012, 0.012, 0.012]), 12)
    foot = mesh.lathe(np.array([[0, 0.03], [0.13, 0.02], [0.14, 0.0], [0, 0.0]]), 64).move((1.05, -0.35, 0.014))
    scene["stand"] = mesh.shape(mesh.merge([stand, foot]), m.metal("Cu", 0.12))
    shade = mesh.lathe(np.stack([np.linspace(0.21, 0.12, 20), np.linspace(1.36, 1.64, 20)], 1), 120).move((1.05, -0.35, 0))
    scene["shade"] = mesh.shape(
        shade,
        {"type": "diffuse", "reflectance": m.texture(None, ["TCS 24"])},
        emitter={"type": "area", "radiance": m.spectrum(spectra.radiance("A", 2600.0)), "sampling_weight": 0.6},
    )
    # Outside: ground, trees, house; the sky is a far surface of daylight, the sun a distant lamp.
    scene["lawn"] = mesh.shape(
        mesh.quad((-25, 2.6, -0.6), (50, 0, 0), (0, 60, 0), (0, 0, 1, 1)),
        m.diffuse(texture.mix(texture.ramp(texture.noise(512, 512, 18, 0.9, 20), -1, 1)), ["Lawn grass GDS91", "TCS 42"]),
        False,
    )
    g = blades(26000, rng, (-6, 4), (5, 16), 0.10)
    g.vertices[:, 2] -= 0.6
    scene["grass"] = mesh.shape(g, m.diffuse(None, ["TCS 42"]))
    crowns, trunks = [], []
    for x, y, w, h in (
        (-3.4, 12.5, 1.5, 3.4),
        (3.6, 15.0, 1.8, 4.2),
        (-5.5, 17, 2.6, 6),
        (5.5, 20, 3, 6.5),
        (-0.9, 30, 3, 4.6),
        (-10, 25, 4, 7),
        (11, 27, 4, 7),
    ):
        n = 9000
        d = rng.normal(0, 1, (n, 3))
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        r = rng.uniform(0.55, 1.05, n)[:, None] * (1 + 0.25 * np.sin(5 * d[:, :1] + 4 * d[:, 2:]) * np.cos(6 * d[:, 1:2]))
        crowns.append(leaves(np.array([x, y, h * 0.62 - 0.6]) + d * r * [w, w, h * 0.42], rng.uniform(0.10, 0.2, n) * (1 + y / 25), rng))
        trunks.append(mesh.tube(np.array([[x, y, -0.6], [x + 0.05, y, 0.4], [x, y, h * 0.5]]), np.array([0.16, 0.13, 0.08]), 12))
    scene["crowns"] = mesh.shape(
        mesh.merge(crowns), m.diffuse(leaf_atlas(9), ["Lawn grass GDS91", "TCS 37", "TCS 43", "TCS 42", "TCS 35", "TCS 34"]), False
    )
    scene["trunks"] = mesh.shape(mesh.merge(trunks), m.diffuse(None, ["Natural umber GDS809 (raw)"]))
    scene["sky"] = mesh.shape(
        mesh.quad((-45, 45, -8), (90, 0, 0), (0, 0, 44)), {"type": "diffuse"}, False, emitter={**m.lamp("D65", 5000.0), "sampling_weight": 2.0}
    )
    scene["front"] = mesh.shape(
        mesh.quad((-30, 18, 32), (60, 0, 0), (0, 11, 0)), {"type": "diffuse"}, False, emitter={**m.lamp("D65", 6000.0), "sampling_weight": 0.7}
    )
    # A second window, outside the picture, at the right of the camera.
    scene["window"] = mesh.shape(
        mesh.quad((2.385, -2.7, 0.8), (0, 0, 1.5), (0, 1.5, 0)), {"type": "diffuse"}, False, emitter={**m.lamp("D65", 4500.0), "sampling_weight": 2.0}
    )
    scene["sun"] = {
        "type": "directional",
        "direction": [-0.30, -0.66, -0.62],
        "irradiance": m.spectrum(spectra.irradiance("D50", 25000.0)),
        "sampling_weight": 1.5,
    }
    return scene, {"origin": [0.42, -3.0, 1.32], "target": [-0.10, 1.2, 0.98], "fov": 66.0, "aperture": 0.003, "focus": 3.2}


NAME = "interior"
TITLE = "Living room with a window"
WHITE: Any = "D65"
DEPTH = 7
PERCENTILE = 90.0
