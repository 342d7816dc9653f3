"""A shop shelf: boxes, tins, jars and bottles with saturated inks and fine print under LED panels."""

from typing import Any

import numpy as np

from . import material as m
from . import mesh, texture
from .mesh import Mesh

# Inks of packaging: measured plastics, printed and coloured materials.
INKS = [
    "TCS 5",
    "TCS 8",
    "Plastic Vinyl GDS398 Red Toy",
    "TCS 20",
    "Cadmium orange 0 GDS786",
    "TCS 29",
    "TCS 32",
    "Brilliant(Hansa)yellowGDS785",
    "TCS 45",
    "TCS 53",
    "Phthalocyaninie blue GDS799",
    "TCS 57",
    "TCS 64",
    "TCS 67",
    "TCS 73",
    "TCS 78",
    "TCS 76",
    "TCS 81",
    "TCS 90",
    "TCS 97",
    "TCS 98",
    "TCS 10",
    "Plastic HDPE GDS386 Yelopaqu",
    "Viridian GDS800",
    "Vermillion GDS779",
    "Ultramarine GDS791 sy vdark",
]
PALE = ["TCS 24", "TCS 33", "TCS 41", "TCS 60", "TCS 82", "TCS 1", "TCS 59", "Paper Cotton Bond PAPR1 100%"]
BLACK, PAPER = "TCS 44", "Plastic HDPE GDS384 Wht Opaq"
BRANDS = [
    "ALPINA",
    "Solmar",
    "KORVA",
    "Brio",
    "Nordic",
    "FERNO",
    "Lumo",
    "Tarantella",
    "MIRABO",
    "Onda",
    "Pilar",
    "Quinto",
    "RUBIN",
    "Zefir",
    "Bergtal",
    "Celesta",
    "DORO",
    "Estrel",
    "Vivo",
    "Kaskad",
]
GOODS = [
    "Whole Oats",
    "Corn Flakes",
    "Cocoa Puffs",
    "Green Tea",
    "Rye Crisp",
    "Tomatoes",
    "Chick Peas",
    "Soup of Leek",
    "Peach Halves",
    "Muesli",
    "Wheat Biscuits",
    "Rice 1 kg",
    "Coffee Dark",
    "Almond Bars",
    "Lemon Curd",
    "Dish Soap",
    "Detergent",
    "Berry Jam",
    "Lentils",
    "Pasta No 5",
]
FINE = (
    "INGREDIENTS wheat flour 62 %, sugar, palm oil, cocoa 8 %, barley malt extract, salt, niacin, iron, vitamin B6, riboflavin, folic acid. May contain traces of "
    "nuts, milk and soya. Store in a cool and dry place. Best before end: see lid. Net weight 500 g e. Packed in a protective atmosphere. "
)


def label(seed: int, rows: int, cols: int, number: int) -> tuple[np.ndarray, list[str]]:
    """One design: six inks, a title, an emblem, rays or stripes, tables and fine print."""
    rng = np.random.default_rng(seed)
    pick = [INKS[i] for i in rng.choice(len(INKS), 3, replace=False)]
    names = [pick[0], pick[1], pick[2], PAPER, BLACK, PALE[int(rng.integers(len(PALE)))]]
    p = texture.Print(rows, cols, 6, 5 if rng.random() < 0.25 else 0)
    unit = cols / 100
    style = int(rng.integers(4))
    v, u = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, cols), indexing="ij")
    if style == 0:
        angle = np.arctan2(v - 0.62, (u - 0.5) * cols / rows)
        p.halftone((np.sin(angle * int(rng.integers(12, 30))) > 0) * texture.ramp(np.hypot(v - 0.62, u - 0.5), 0.1, 0.5), 1)
    elif style == 1:
        p.halftone(texture.ramp(v, 0.25, 1.0), 1)
        for k in range(7):
            p.rectangle(0, 0.55 + 0.012 * k * k / 2, 1, 0.552 + 0.012 * k * k / 2 + 0.004, 3)
    elif style == 2:
        p.halftone(0.9 * ((u * 7 + v * 5) % 1 > 0.5) * texture.ramp(v, 0.5, 0.9), 2)
    else:
        dots = np.hypot((u * cols / rows * 16) % 1 - 0.5, (v * 16) % 1 - 0.5)
        p.halftone((dots < 0.15 + 0.28 * v).astype(float), 1)
    p.rectangle(0, 0.055, 1, 0.27, int(rng.choice([2, 3, 1, 4])))
    dark = rng.random() < 0.5
    p.text(
        0.5,
        0.09,
        BRANDS[number % len(BRANDS)],
        int(21 * unit * min(1.0, 5.2 / len(BRANDS[number % len(BRANDS)]))),
        0 if dark else 3,
        True,
        anchor="ma",
    )
    p.text(0.5, 0.29, GOODS[(number * 7 + 3) % len(GOODS)], int(9.5 * unit), 4 if dark else 3, True, anchor="ma")
    p.text(0.5, 0.375, "since 1924 · extra quality · 100 % natural", int(3.6 * unit), 4, anchor="ma")
    kind = int(rng.integers(4))
    if kind == 0:
        for k in range(9):
            x, y, r = 0.5 + rng.normal(0, 0.16), 0.6 + rng.normal(0, 0.06), 0.09
            ry = r * cols / rows
            p.ellipse(x - r, y - ry, x + r, y + ry, int(rng.choice([2, 1])))
            p.ellipse(x - r * 0.6, y - ry * 0.7, x - r * 0.25, y - ry * 0.35, 3)
    elif kind == 1:
        p.ellipse(0.2, 0.46, 0.8, 0.46 + 0.6 * cols / rows, 3)
        p.ellipse(0.24, 0.46 + 0.04 * cols / rows, 0.76, 0.46 + 0.56 * cols / rows, 2)
        texture_tone = np.clip(0.5 + 0.35 * texture.noise(rows, cols, seed, 1.2, 5), 0, 1) * (
            np.hypot((u - 0.5), (v - 0.46 - 0.3 * cols / rows) * rows / cols) < 0.22
        )
        p.halftone(texture_tone, 5)
    elif kind == 2:
        for k in range(6):
            p.polygon([(0.1 + 0.14 * k, 0.75), (0.17 + 0.14 * k, 0.47 + 0.05 * (k % 3)), (0.24 + 0.14 * k, 0.75)], 1 + k % 3)
        p.rectangle(0.08, 0.74, 0.92, 0.76, 4)
    else:
        p.text(0.5, 0.45, str(int(rng.integers(2, 99))), int(38 * unit), int(rng.choice([2, 3])), True, anchor="ma")
        p.text(0.5, 0.72, "VITAMINS  ·  FIBRE  ·  IRON", int(4.4 * unit), 4, True, anchor="ma")
    p.rectangle(0.04, 0.80, 0.56, 0.975, 3)
    p.rectangle(0.045, 0.803, 0.555, 0.835, 4)
    size = max(4, int(2.5 * unit))
    at, line = int(rng.integers(0, 60)), 0
    while 0.845 + line * size * 1.15 / rows < 0.955:
        p.text(0.055, 0.845 + line * size * 1.15 / rows, (FINE * 3)[at : at + 36], size, 4)
        at, line = at + 36, line + 1
    p.text(0.055, 0.806, "Nutrition per 100 g   kJ 1547", max(4, int(2.8 * unit)), 3, True)
    p.rectangle(0.62, 0.86, 0.96, 0.975, 3)
    x = 0.64
    while x < 0.93:
        w = float(rng.choice([0.006, 0.009, 0.014]))
        p.rectangle(x, 0.868, x + w, 0.955, 4)
        x += w + float(rng.choice([0.006, 0.010]))
    p.text(0.64, 0.957, "4 006381 333931", max(4, int(2.3 * unit)), 4)
    p.ellipse(0.70, 0.70, 0.96, 0.70 + 0.26 * cols / rows, 2)
    p.text(0.83, 0.70 + 0.06 * cols / rows, "NEW", int(8 * unit), 3, True, anchor="ma")
    p.text(0.83, 0.70 + 0.155 * cols / rows, "+ 20 %", int(4.5 * unit), 3, anchor="ma")
    return p.shares(), names


def tin(radius: float, height: float) -> tuple[Mesh, Mesh]:
    """A paper label with its seam behind, and the metal rims and beads."""
    angle = np.linspace(np.pi, 3 * np.pi, 97)
    z = np.linspace(0.06, 0.94, 24) * height
    ring = radius * (1 - 0.004 * (np.cos(z / height * 60) > 0.6))
    side = mesh.grid(
        np.stack([np.cos(angle)[None] * ring[:, None], np.sin(angle)[None] * ring[:, None], np.broadcast_to(z[:, None], (24, 97))], 2), (2.0, 1.0)
    )
    rim = np.array([[0.0, 0.0], [1.0, 0.0], [1.02, 0.01], [1.02, 0.03], [0.985, 0.05], [0.985, 0.06]]) * [radius, height]
    top = np.array(
        [[0.985, 0.94], [0.985, 0.955], [1.02, 0.97], [1.02, 0.995], [0.97, 1.0], [0.96, 0.98], [0.6, 0.975], [0.55, 0.985], [0.0, 0.985]]
    ) * [radius, height]
    return side, mesh.merge([mesh.lathe(rim, 64), mesh.lathe(top, 64)])


def bottle(radius: float, height: float) -> tuple[Mesh, Mesh, Mesh]:
    """Body, label and cap of a bottle."""
    body = np.array([[0, 0], [0.96, 0], [1.0, 0.015], [1.0, 0.60], [0.96, 0.66], [0.78, 0.74], [0.50, 0.81], [0.36, 0.86], [0.34, 0.90]]) * [
        radius,
        height,
    ]
    fine = np.stack([np.interp(np.linspace(0, 1, 60), np.linspace(0, 1, 9), body[:, k]) for k in (0, 1)], 1)
    cap = np.array([[0.40, 0.89], [0.40, 0.995], [0.37, 1.0], [0.0, 1.0]]) * [radius, height]
    angle = np.linspace(np.pi, 3 * np.pi, 97)
    z = np.linspace(0.10, 0.56, 12) * height
    r = radius * 1.006
    sheet = mesh.grid(
        np.stack(
            [np.broadcast_to(np.cos(angle) * r, (12, 97)), np.broadcast_to(np.sin(angle) * r, (12, 97)), np.broadcast_to(z[:, None], (12, 97))], 2
        ),
        (2.0, 1.0),
    )
    ribs = mesh.lathe(cap, 96)
    edge = np.hypot(ribs.vertices[:, 0], ribs.vertices[:, 1]) > 0.39 * radius
    ribs.vertices[edge, :2] *= (1 + 0.03 * np.sign(np.sin(48 * np.arctan2(ribs.vertices[edge, 1], ribs.vertices[edge, 0]))))[:, None]
    return mesh.lathe(fine, 72), sheet, ribs


def build() -> tuple[dict[str, Any], dict[str, Any]]:
    rng = np.random.default_rng(4)
    scene: dict[str, Any] = {"type": "scene"}
    metal_parts: list[Mesh] = []
    number = [0]

    def add(key: str, shape_: Any) -> None:
        scene[f"{key}{len(scene)}"] = shape_

    def boxes(x: float, z: float, w: float, d: float, h: float, count: int, stack: int = 1) -> float:
        number[0] += 1
        shares, names = label(100 + number[0], int(h * 2600), int(w * 2600), number[0])
        parts = []
        for i in range(count):
            for s in range(stack):
                low = np.array([0, 0, 0])
                b = mesh.box(low, (w, d, h), [(0, 0, 1, 1), (0, 0, 0.35, 1), (0, 0, 1, 1), (0, 0, 0.35, 1), (0, 0.9, 1, 1), (0, 0, 1, 0.1)])
                b = b.move((-w / 2, 0, 0)).move((x + w / 2 + i * (w + 0.004), -0.30 + 0.03 * rng.random(), z + s * h), 1.0, rng.normal(0, 0.025))
                parts.append(b)
        add("box", mesh.shape(mesh.merge(parts), m.plastic(shares, names, float(rng.choice([0.08, 0.14, 0.25]))), False))
        return x + count * (w + 0.004) + 0.012

    def tins(x: float, z: float, r: float, h: float, count: int, stack: int = 2) -> float:
        number[0] += 1
        shares, names = label(100 + number[0], int(h * 2600), int(np.pi * r * 2600), number[0])
        side, rims = tin(r, h)
        sides = []
        for i in range(count):
            for s in range(stack):
                for row in range(2):
                    at = (x + r + i * (2 * r + 0.004), -0.30 + r + 0.012 * rng.random() + row * (2 * r + 0.005), z + s * h)
                    turn = rng.normal(-np.pi / 2 + np.pi / 2, 0.25)
                    sides.append(side.move(at, 1.0, turn))
                    metal_parts.append(rims.move(at))
        add("tin", mesh.shape(mesh.merge(sides), m.plastic(shares, names, 0.12)))
        return x + count * (2 * r + 0.004) + 0.012

    def bottles(x: float, z: float, r: float, h: float, count: int, ink: str, cap_ink: str) -> float:
        number[0] += 1
        shares, names = label(100 + number[0], int(0.46 * h * 2600), int(np.pi * r * 2600), number[0])
        body, sheet, cap = bottle(r, h)
        bodies, sheets, caps = [], [], []
        for i in range(count):
            for row in range(2):
                at, turn = (x + r + i * (2 * r + 0.006), -0.29 + r + 0.01 * rng.random() + row * 2.1 * r, z), rng.normal(0, 0.2)
                bodies.append(body.move(at))
                sheets.append(sheet.move(at, 1.0, turn))
                caps.append(cap.move(at))
        add("body", mesh.shape(mesh.merge(bodies), m.plastic(None, [ink], 0.05)))
        add("sheet", mesh.shape(mesh.merge(sheets), m.plastic(shares, names, 0.18)))
        add("cap", mesh.shape(mesh.merge(caps), m.plastic(None, [cap_ink], 0.12)))
        return x + count * (2 * r + 0.006) + 0.012

    levels = [0.0, 0.36, 0.70]
    x = -0.72
    x = boxes(x, levels[0], 0.19, 0.07, 0.285, 2)
    x = boxes(x, levels[0], 0.165, 0.06, 0.24, 2)
    x = bottles(x, levels[0], 0.042, 0.27, 3, "TCS 53", "TCS 5")
    x = boxes(x, levels[0], 0.20, 0.07, 0.30, 1)
    x = bottles(x, levels[0], 0.038, 0.24, 3, "Plastic HDPE GDS391 Blu-Grn", "Plastic HDPE GDS386 Yelopaqu")
    x = -0.72
    x = tins(x, levels[1], 0.037, 0.11, 3)
    x = boxes(x, levels[1], 0.15, 0.05, 0.21, 2)
    x = tins(x, levels[1], 0.042, 0.115, 3)
    x = boxes(x, levels[1], 0.11, 0.06, 0.075, 2, 3)
    x = tins(x, levels[1], 0.035, 0.10, 3)
    x = boxes(x, levels[1], 0.14, 0.05, 0.20, 1)
    x = -0.72
    x = bottles(x, levels[2], 0.036, 0.23, 3, "TCS 24", "TCS 8")
    x = boxes(x, levels[2], 0.16, 0.06, 0.22, 2)
    x = boxes(x, levels[2], 0.12, 0.08, 0.16, 2)
    x = bottles(x, levels[2], 0.040, 0.24, 2, "TCS 98", PAPER)
    x = boxes(x, levels[2], 0.17, 0.06, 0.235, 2)
    # Boards with price rails, the perforated back and the lamp above.
    steel, white = m.metal("Al", 0.22), m.plastic(None, ["Painted Aluminum GDS333 LgGr"], 0.25)
    boards = [mesh.box((-1.2, -0.33, z - 0.025), (1.2, 0.2, z)) for z in (*levels, 1.03)]
    add("boards", mesh.shape(mesh.merge(boards), white, False))
    tags = texture.Print(128, 4096, 4, 0)
    for k in range(11):
        u = 0.02 + k * 0.09
        tags.rectangle(u, 0.08, u + 0.055, 0.92, 1)
        tags.rectangle(u, 0.08, u + 0.055, 0.30, 2)
        tags.text(u + 0.003, 0.09, GOODS[(k * 3 + 1) % 20].upper(), 24, 1, True)
        tags.text(u + 0.053, 0.34, f"{rng.integers(0, 9)}.{rng.integers(10, 99)}", 66, 3, True, anchor="ra")
        tags.text(u + 0.003, 0.36, "1 kg = 4.98", 17, 3)
        tags.text(u + 0.003, 0.54, "A 731 004 86", 15, 3)
        for b in range(30):
            if rng.random() < 0.55:
                tags.rectangle(u + 0.003 + b * 0.0007, 0.72, u + 0.003 + b * 0.0007 + 0.0004, 0.88, 3)
    names = ["TCS 49", PAPER, "TCS 29", BLACK]
    rails = [
        mesh.quad((-1.2, -0.335, z - 0.036), (2.4, 0, 0), (0, -0.012, 0.042), (0.07 * k, 0, 1 + 0.07 * k, 1)) for k, z in enumerate((*levels, 1.03))
    ]
    add("rails", mesh.shape(mesh.merge(rails), m.plastic(tags.shares(), names, 0.15), False))
    v, u = np.meshgrid(np.arange(256) / 256, np.arange(256) / 256, indexing="ij")
    holes = texture.ramp(0.24 - np.hypot((u * 8) % 1 - 0.5, (v * 8) % 1 - 0.5), -0.03, 0.03)
    add(
        "back",
        mesh.shape(
            mesh.quad((-1.2, 0.19, -0.3), (2.4, 0, 0), (0, 0, 1.6), (0, 0, 12, 8)), m.plastic(texture.mix(holes), ["TCS 72", "TCS 63"], 0.3), False
        ),
    )
    add("rims", mesh.shape(mesh.merge(metal_parts), steel))
    tone = texture.mix(texture.ramp(texture.noise(512, 512, 5, 0.8, 10), -1, 1.5))
    add("floor", mesh.shape(mesh.quad((-4, -5, -0.9), (8, 0, 0), (0, 6, 0), (0, 0, 8, 8)), m.plastic(tone, ["TCS 14", "TCS 36"], 0.15), False))
    far = np.random.default_rng(9).dirichlet(np.ones(8) * 0.12, (14, 60)).astype(np.float32)
    far = np.repeat(np.repeat(far, 8, 0), 8, 1)
    add("opposite", mesh.shape(mesh.quad((4, -2.4, -0.9), (-8, 0, 0), (0, 0, 2.2)), m.diffuse(far, INKS[:4] + INKS[8:12]), False))
    add("ceiling", mesh.shape(mesh.quad((-4, 1, 2.2), (8, 0, 0), (0, -6, 0)), m.diffuse(None, [PAPER]), False))
    scene["panels"] = mesh.shape(
        mesh.merge([mesh.quad((x0, -1.25, 2.15), (0, 0.3, 0), (1.3, 0, 0)) for x0 in (-2.3, -0.65, 1.0)]),
        {"type": "diffuse"},
        False,
        emitter=m.lamp("LED-B4", 9000.0),
    )
    scene["strip"] = mesh.shape(
        mesh.quad((-1.1, -0.52, 1.33), (0, 0.03, 0), (2.2, 0, 0)), {"type": "diffuse"}, False, emitter=m.lamp("LED-B3", 22000.0)
    )
    return scene, {"origin": [0.10, -1.48, 0.62], "target": [-0.01, 0.0, 0.475], "fov": 49.0, "aperture": 0.002, "focus": 1.2}


NAME = "shelf"
TITLE = "Shop shelf with packaging under LED panels"
WHITE: Any = "LED-B4"
DEPTH = 7
