"""A portrait: a head with measured skin, strands of hair, knitted and woven clothes, studio lamps."""

from typing import Any

import mitsuba as mi
import numpy as np

from . import material as m
from . import mesh, texture
from .mesh import Mesh

TURN = 0.30
EYES = [np.array([s * 0.0310, -0.0735, 0.0030]) for s in (-1, 1)]
EYE_RADIUS = 0.0124


def ellipsoid(p: np.ndarray, centre: Any, radii: Any) -> np.ndarray:
    """Distance to an ellipsoid, to first order."""
    q = (p - np.asarray(centre, np.float32)) / np.asarray(radii, np.float32)
    k = np.sqrt((q * q).sum(-1))
    g = np.sqrt(((q / np.asarray(radii, np.float32)) ** 2).sum(-1))
    return k * (k - 1) / (g + 1e-9)


def capsule(p: np.ndarray, a: Any, b: Any, ra: float, rb: float) -> np.ndarray:
    """Distance to a cone with round ends."""
    a, b = np.asarray(a, np.float32), np.asarray(b, np.float32)
    t = np.clip(((p - a) @ (b - a)) / ((b - a) @ (b - a)), 0, 1)
    return np.sqrt(((p - a - t[..., None] * (b - a)) ** 2).sum(-1)) - (ra + (rb - ra) * t)


def join(a: np.ndarray, b: np.ndarray, k: float) -> np.ndarray:
    """Union with a fillet of about k."""
    h = np.clip(0.5 + 0.5 * (b - a) / k, 0, 1)
    return b + (a - b) * h - k * h * (1 - h)


def cut(a: np.ndarray, b: np.ndarray, k: float) -> np.ndarray:
    """Removes b from a with a fillet of about k."""
    return -join(-a, b, k)


def head(p: np.ndarray) -> np.ndarray:
    """Signed distance (m) to head, ears and neck; the face looks along −y."""
    q = np.stack([np.abs(p[..., 0]), p[..., 1], p[..., 2]], -1)
    d = ellipsoid(q, (0, 0.016, 0.040), (0.0745, 0.096, 0.086))
    d = join(d, ellipsoid(q, (0, -0.028, -0.028), (0.0600, 0.064, 0.088)), 0.030)
    d = join(d, ellipsoid(q, (0.0, -0.038, -0.078), (0.046, 0.046, 0.036)), 0.025)
    d = join(d, ellipsoid(q, (0.050, -0.006, -0.062), (0.013, 0.030, 0.026)), 0.030)
    d = join(d, ellipsoid(q, (0, -0.079, -0.1005), (0.019, 0.012, 0.013)), 0.022)
    d = join(d, ellipsoid(q, (0.0400, -0.060, -0.026), (0.022, 0.018, 0.020)), 0.026)
    d = join(d, ellipsoid(q, (0.0260, -0.0770, 0.0235), (0.026, 0.0085, 0.0075)), 0.016)
    d = cut(d, ellipsoid(q, (0.0310, -0.0985, 0.0035), (0.0185, 0.0150, 0.0130)), 0.016)
    d = join(d, capsule(q, (0, -0.0815, 0.0140), (0, -0.1050, -0.0300), 0.0078, 0.0098), 0.014)
    d = join(d, ellipsoid(q, (0, -0.1075, -0.0335), (0.0112, 0.0112, 0.0100)), 0.008)
    d = join(d, ellipsoid(q, (0.0118, -0.0970, -0.0370), (0.0072, 0.0100, 0.0078)), 0.005)
    d = cut(d, ellipsoid(q, (0.0066, -0.1030, -0.0450), (0.0040, 0.0062, 0.0048)), 0.003)
    d = cut(d, capsule(q, (0, -0.0985, -0.0470), (0, -0.0965, -0.0560), 0.0022, 0.0030), 0.005)
    d = join(d, ellipsoid(q, (0.0075, -0.0885, -0.0615), (0.0165, 0.0085, 0.0056)), 0.006)
    d = join(d, ellipsoid(q, (0.0, -0.0885, -0.0722), (0.0185, 0.0092, 0.0062)), 0.006)
    d = cut(d, ellipsoid(q, (0.0, -0.0990, -0.0666), (0.0240, 0.0080, 0.0010)), 0.0025)
    d = cut(d, ellipsoid(q, (0.0, -0.0960, -0.0835), (0.0150, 0.0050, 0.0050)), 0.008)
    lid = EYES[1]
    d = join(d, np.sqrt(((q - lid.astype(np.float32)) ** 2).sum(-1)) - (EYE_RADIUS + 0.0014), 0.004)
    open_z = 0.0008 + 0.0012 * (q[..., 0] - 0.031) / 0.013
    almond = ellipsoid(np.stack([q[..., 0], q[..., 1], q[..., 2] - open_z], -1), (0.0310, -0.0880, 0.0016), (0.0140, 0.0110, 0.0042))
    d = cut(d, almond, 0.0012)
    ear = ellipsoid(q, (0.0770, 0.014, -0.004), (0.0075, 0.020, 0.030))
    ear = cut(ear, ellipsoid(q, (0.0850, 0.010, 0.000), (0.0070, 0.0125, 0.0190)), 0.004)
    ear = join(ear, capsule(q, (0.0800, 0.012, 0.012), (0.0800, 0.020, -0.010), 0.0028, 0.0022), 0.004)
    d = join(d, ear, 0.006)
    d = join(d, capsule(p, (0, 0.018, -0.070), (0, 0.036, -0.220), 0.051, 0.056), 0.022)
    return d


def body(p: np.ndarray) -> np.ndarray:
    """Signed distance (m) to the pullover."""
    d = capsule(p, (-0.150, 0.050, -0.285), (0.150, 0.050, -0.285), 0.062, 0.062)
    d = join(d, ellipsoid(p, (0, 0.050, -0.38), (0.20, 0.115, 0.17)), 0.05)
    d = join(d, capsule(p, (0, 0.034, -0.165), (0, 0.042, -0.26), 0.060, 0.085), 0.05)
    folds = 0.0035 * np.sin(38 * p[..., 0] + 14 * p[..., 2] + 2 * np.sin(20 * p[..., 2])) * np.clip((-0.2 - p[..., 2]) * 8, 0, 1)
    return d + folds


def surface(distance: Any, low: Any, high: Any, step: float) -> Mesh:
    """Marching cubes, then two Newton steps; uv is (x, z) from the front."""
    from skimage.measure import marching_cubes

    axes = [np.arange(a, b, step, dtype=np.float32) for a, b in zip(low, high)]
    field = np.empty([len(a) for a in axes], np.float32)
    for i, x in enumerate(axes[0]):
        yy, zz = np.meshgrid(axes[1], axes[2], indexing="ij")
        field[i] = distance(np.stack([np.full_like(yy, x), yy, zz], -1))
    v, f, _, _ = marching_cubes(field, 0.0, spacing=(step, step, step))
    v = v + np.asarray(low)
    for _i in range(2):
        d = distance(v.astype(np.float32))
        g = np.stack([distance((v + e).astype(np.float32)) - d for e in np.eye(3) * 4e-4], -1) / 4e-4
        v = v - (d / np.maximum((g * g).sum(-1), 0.1))[:, None] * g * 0.9
    uv = np.stack([v[:, 0] / 0.32 + 0.5, v[:, 2] / 0.40 + 0.55], 1)
    return Mesh(v, f[:, ::-1], uv)


def skin() -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Shares of skin tones over the face seen from the front, and the relief of pores and fine lines."""
    n = 2048
    v, u = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n, indexing="ij")
    x, z = (u - 0.5) * 0.32, (v - 0.55) * 0.40
    a = np.abs(x)

    def spot(cx: float, cz: float, rx: float, rz: float) -> np.ndarray:
        return np.exp(-(((a - cx) / rx) ** 2) - ((z - cz) / rz) ** 2)

    flush = (
        0.75 * spot(0.040, -0.035, 0.022, 0.018)
        + 0.75 * spot(0.0, -0.034, 0.014, 0.012)
        + 0.35 * spot(0, -0.1, 0.02, 0.015)
        + 0.5 * spot(0.080, 0, 0.015, 0.03)
    )
    flush = np.clip(flush + 0.10 + 0.17 * texture.noise(n, n, 1, 1.5, 6) + 0.12 * texture.noise(n, n, 2, 0.8, 60, 500), 0, 1)
    dark = (
        0.45 * spot(0.031, -0.010, 0.014, 0.007) + 0.25 * spot(0.031, 0.012, 0.016, 0.006) + 0.10 * texture.ramp(texture.noise(n, n, 3, 1.3, 8), 0, 2)
    )
    rng = np.random.default_rng(7)
    freckle = np.zeros((n, n))
    for _ in range(420):
        fx, fz = rng.normal(0, 0.034), rng.normal(-0.022, 0.024)
        r = rng.gamma(4, 0.00017)
        i0, j0 = int((fz / 0.40 + 0.55) * n), int((fx / 0.32 + 0.5) * n)
        w = 14
        if w < i0 < n - w and w < j0 < n - w:
            ii, jj = slice(i0 - w, i0 + w), slice(j0 - w, j0 + w)
            freckle[ii, jj] = np.maximum(freckle[ii, jj], rng.uniform(0.15, 0.6) * np.exp(-((x[ii, jj] - fx) ** 2 + (z[ii, jj] - fz) ** 2) / r**2))
    bow = 0.0018 * np.exp(-((a / 0.004) ** 2))
    upper = texture.ramp(-0.0560 - 0.0035 * (a / 0.022) ** 2 - bow - z, 0, 0.0012) * texture.ramp(z + 0.0672, -0.001, 0.0005)
    lower = texture.ramp(z + 0.0795 - 0.008 * (a / 0.022) ** 2, 0, 0.0015) * texture.ramp(-0.0660 - z, -0.0005, 0.0005)
    lips = np.clip(upper + lower, 0, 1) * texture.ramp(0.0238 - a, 0, 0.003)
    crack = texture.ramp(np.abs(texture.noise(n, n, 9, 0.9, 40, 400)), 0.0, 0.5)
    pores = texture.ramp(texture.noise(n, n, 4, 0.15, 90, 260), 1.2, 2.6)
    # Fine lines cross the skin at the scale of a sample and less.
    lines = 0.13 * texture.ramp(0.25 - np.abs(texture.noise(n, n, 11, 0.7, 70, 420)), 0, 0.25) + 0.10 * texture.ramp(
        texture.noise(n, n, 12, 0.3, 60, 300), 0.3, 2.2
    )
    shares = texture.mix(0.80 * flush, np.clip(dark, 0, 1), freckle, np.clip(0.35 * pores + lines, 0, 1), 0.45 * lips, 0.45 * lips * (1 - crack))
    relief = (
        0.00022 * texture.noise(n, n, 5, 0.55, 60, 420)
        - 0.0004 * pores
        + 0.0003 * lips * (np.sin(x * 2600 + 2 * texture.noise(n, n, 6, 1.6, 5)) - 0.4)
    )
    return shares, relief, ["Skin 36", "Skin 97", "Skin 3", "Skin 61", "Skin 17", "TCS 11", "TCS 7"]


def on_head(p: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """Pushes points out of the skull, the neck and the pullover to at least an offset."""
    for _ in range(2):
        q = (p - [0, 0.016, 0.034]) / [0.0765, 0.098, 0.090]
        k = np.linalg.norm(q, axis=-1)
        far = 1 + offset / 0.085
        p = np.where((k < far)[:, None], [0, 0.016, 0.034] + q / k[:, None] * far[:, None] * [0.0765, 0.098, 0.090], p)
        t = (p - [0, 0.03, 0]) * [1, 1, 0]
        r = np.linalg.norm(t, axis=1)
        need = (p[:, 2] < -0.03) & (r < 0.066 + offset)
        p = np.where(need[:, None], p + t / (r[:, None] + 1e-9) * (0.066 + offset - r)[:, None], p)
    return p


def hair(count: int, rng: np.random.Generator) -> list[np.ndarray]:
    """Strands that leave the scalp away from a parting, fall over the ears and lie on the shoulders."""
    theta, phi = np.arccos(rng.uniform(-0.35, 1, count)), rng.uniform(0, 2 * np.pi, count)
    d = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], 1)
    root = np.array([0, 0.016, 0.034]) + d * [0.0765, 0.098, 0.090]
    line = 0.083 - 0.20 * np.abs(root[:, 0]) - 0.030 * rng.random(count) ** 2
    keep = np.where(root[:, 1] < -0.018, root[:, 2] > line, root[:, 2] > -0.045 - 0.6 * np.clip(root[:, 1], -0.02, 0.05))
    keep &= ~((np.abs(root[:, 0]) > 0.055) & (root[:, 1] < 0.004) & (root[:, 2] < 0.040))
    d, p = d[keep], root[keep]
    n = len(p)
    side = np.sign(p[:, 0] - 0.022 + 0.003 * rng.normal(size=n))
    lock = np.floor(np.arctan2(p[:, 1], p[:, 0]) * 14) + 31 * np.floor(p[:, 2] * 90)
    wave_phase = (np.sin(lock * 12.9898) * 43758.5453) % 6.283
    flow = np.stack([side * 0.9 * (1 - 0.85 * np.clip(p[:, 1] / 0.05, 0, 1)), 0.55 + 0.8 * np.clip(0.02 - p[:, 1], 0, 0.1) * 8, np.full(n, 0.0)], 1)
    flow -= (flow * d).sum(1, keepdims=True) * d
    flow /= np.linalg.norm(flow, axis=1, keepdims=True)
    velocity = flow + 0.12 * d + 0.05 * rng.normal(size=(n, 3))
    offset = rng.uniform(0.002, 0.017, n)
    steps, length = 30, rng.uniform(0.27, 0.34, n)
    points = [p.copy()]
    for k in range(steps):
        fall = min(1.0, 0.10 + k / 9)
        velocity = (
            0.80 * velocity
            + fall * np.array([0, 0.02, -0.34])
            + 0.022 * np.stack([np.sin(wave_phase + k * 0.8), np.cos(wave_phase * 1.3 + k * 0.7), 0 * wave_phase], 1)
            + 0.010 * rng.normal(size=(n, 3))
        )
        velocity /= np.linalg.norm(velocity, axis=1, keepdims=True)
        p = p + velocity * (length / steps)[:, None]
        # The face stays free: hair in front of the ears is carried back.
        front = (p[:, 1] < -0.012) & (p[:, 2] < 0.055)
        p[:, 1] = np.where(front, p[:, 1] + 0.006, p[:, 1])
        p = on_head(p, offset)
        points.append(p.copy())
    paths = np.stack(points, 1)
    return [paths[i] for i in range(n)]


def strands(paths: list[np.ndarray], radius: float, bsdf: dict[str, Any]) -> dict[str, Any]:
    """Curves as a shape of Mitsuba."""
    lines = []
    for path in paths:
        t = np.linspace(0, 1, len(path))
        r = radius * (1 - 0.6 * t**3)
        lines.append("\n".join(f"{a:.6f} {b:.6f} {c:.6f} {w:.6f}" for (a, b, c), w in zip(path, r)))
    mesh._COUNT[0] += 1
    file = mesh._FOLDER / f"{mesh._COUNT[0]}.txt"
    file.write_text("\n\n".join(lines) + "\n")
    return {"type": "bsplinecurve", "filename": str(file), "bsdf": bsdf}


def brows_and_lashes(rng: np.random.Generator) -> list[np.ndarray]:
    out = []
    for s in (-1, 1):
        for _ in range(900):
            t = rng.random()
            x = 0.012 + 0.036 * t
            z = 0.0215 + 0.0065 * np.sin(np.pi * min(0.10 + t * 0.80, 1)) - 0.001 * t**3 + rng.normal(0, 0.0017 * (1 - 0.65 * t))
            p = np.array([s * x, -0.12, z])
            for _k in range(24):
                p = p + np.array([0, 0.9, 0]) * max(float(head(p[None].astype(np.float32))[0]), -0.002)
            step = np.array([s * (0.35 + 0.65 * t), -0.25, 0.75 - 0.9 * t]) * 0.0016
            out.append(np.array([p + step * k + np.array([0, 0.0003 * k * k, 0]) for k in range(5)]))
        for _ in range(110):
            t = rng.uniform(-1, 1)
            upper = rng.random() < 0.68
            x = 0.031 + 0.0132 * t
            z = 0.003 + (0.0052 if upper else -0.0035) * np.sqrt(max(0.0, 1 - t * t)) + 0.0012 * t
            c = EYES[1]
            r = np.sqrt(max((EYE_RADIUS + 0.0012) ** 2 - (x - c[0]) ** 2 - (z - c[2]) ** 2, 1e-8))
            p = np.array([x, c[1] - r, z])
            up = 0.75 if upper else -0.6
            length = (0.0065 if upper else 0.004) * rng.uniform(0.7, 1.1)
            k = np.linspace(0, 1, 6)[:, None]
            path = p + length * np.concatenate([0.5 * t * k, -0.9 * k + 0.25 * k**2, up * k**2 - 0.12 * k * (1 if upper else 0)], 1)
            out.append(path * [s, 1, 1])
    return out


def eye_texture() -> np.ndarray:
    """Sclera with veins, limbus, iris with fibres, pupil; seen along the axis, ±EYE_RADIUS."""
    n = 512
    v, u = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n), indexing="ij")
    r, a = np.hypot(u, v), np.arctan2(v, u)
    fibre = texture.noise(512, 64, 3, 0.6, 3)[((a / 2 / np.pi + 0.5) * 511).astype(int) % 512, np.clip(r * 63, 0, 63).astype(int)]
    veins = texture.ramp(0.12 - np.abs(texture.noise(n, n, 5, 1.4, 6)), 0, 0.1) * texture.ramp(r, 0.55, 0.9) * 0.35
    iris = texture.ramp(0.52 - r, 0, 0.02)
    limbus = iris * texture.ramp(r, 0.43, 0.52)
    pupil = texture.ramp(0.17 - r, 0, 0.015)
    return texture.mix(
        veins,
        iris,
        np.clip(iris * texture.ramp(fibre, -0.2, 1.6) * 0.8, 0, 1),
        np.clip(0.8 * limbus, 0, 1),
        iris * np.exp(-(((r - 0.2) / 0.05) ** 2)) * 0.6,
        pupil,
    )


def knit(n: int, across: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Ribs of stitches: depth between the yarns, and fuzz."""
    v, u = np.meshgrid(np.arange(n) / n * across * 1.3, np.arange(n) / n * across, indexing="ij")
    u = u + 0.05 * texture.noise(n, n, seed, 1.4, 4)
    d = (u % 1) - 0.5
    stitch = 0.5 + 0.5 * np.cos(2 * np.pi * (v + 0.9 * np.abs(d)))
    depth = np.clip(1 - stitch * np.cos(np.pi * d) ** 0.6, 0, 1)
    return depth, texture.noise(n, n, seed + 1, 0.4, 80)


def turned(mesh_: Mesh) -> Mesh:
    return Mesh(mesh_.vertices @ mesh.rotation_z(TURN).T, mesh_.faces, mesh_.uv)


def build() -> tuple[dict[str, Any], dict[str, Any]]:
    rng = np.random.default_rng(17)
    scene: dict[str, Any] = {"type": "scene"}
    shares, relief, tones = skin()
    face = surface(head, (-0.10, -0.125, -0.215), (0.10, 0.125, 0.14), 0.0014)
    flesh = {"type": "roughplastic", "alpha": 0.30, "int_ior": 1.40, "distribution": "ggx", "diffuse_reflectance": m.texture(shares, tones)}
    bumped = {
        "type": "bumpmap",
        "scale": 1.0,
        "arbitrary": {"type": "bitmap", "raw": True, "bitmap": mi.Bitmap(relief[:, :, None].astype(np.float32))},
        "bsdf": flesh,
    }
    scene["head"] = mesh.shape(turned(face), {"type": "twosided", "bsdf": bumped})
    ball = mesh.sphere(90, 180)
    ball.uv = np.stack([ball.vertices[:, 0] / 2 + 0.5, ball.vertices[:, 2] / 2 + 0.5], 1)
    balls = []
    for c in EYES:
        look = mesh.rotation_z(-TURN * 0.9)
        b = Mesh(ball.vertices @ look.T, ball.faces, ball.uv)
        cornea = np.exp(-((np.hypot(ball.vertices[:, 0], ball.vertices[:, 2]) / 0.42) ** 4)) * (ball.vertices[:, 1] < 0)
        balls.append(b.move((0, 0, 0), EYE_RADIUS * (1 + 0.045 * cornea)[:, None]).move(c))
    scene["eyes"] = mesh.shape(
        turned(mesh.merge(balls)),
        m.plastic(eye_texture(), ["Lead White GDS796", "TCS 4", "TCS 65", "TCS 68", "TCS 44", "TCS 30", "Bone black GDS808"], 0.015),
    )
    locks = hair(20000, rng)
    turn = mesh.rotation_z(TURN).T
    order = rng.permutation(len(locks))
    for k, (name, gain, share) in enumerate(
        (("Natural umber GDS809 (raw)", 0.55, 0.5), ("Burnt umber GDS811", 0.7, 0.3), ("Italian nat sienna GDS805", 0.55, 0.2))
    ):
        first = int(sum((0.5, 0.3, 0.2)[:k]) * len(locks))
        chosen = [locks[i] @ turn for i in order[first : first + int(share * len(locks))]]
        scene[f"hair{k}"] = strands(
            chosen, 0.00036, {"type": "roughplastic", "alpha": 0.22, "int_ior": 1.55, "diffuse_reflectance": m.texture(None, [name], gain=gain)}
        )
    scalp = mesh.sphere(120, 240).move((0, 0.016, 0.034), (0.0755, 0.097, 0.0885))
    high = scalp.vertices[scalp.faces].mean(1)
    top = np.where(high[:, 1] < -0.018, high[:, 2] > 0.083 - 0.20 * np.abs(high[:, 0]) + 0.006, high[:, 2] > -0.03)
    top &= ~((np.abs(high[:, 0]) > 0.053) & (high[:, 1] < 0.008) & (high[:, 2] < 0.046))
    cap = Mesh(scalp.vertices, scalp.faces[top], scalp.uv)
    scene["scalp"] = mesh.shape(turned(cap), m.diffuse(None, ["Natural umber GDS809 (raw)"], gain=0.4))
    scene["brows"] = strands(
        [q @ turn for q in brows_and_lashes(rng)],
        0.00016,
        {"type": "roughplastic", "alpha": 0.3, "diffuse_reflectance": m.texture(None, ["Natural umber GDS809 (raw)"], gain=0.45)},
    )
    # Pullover and scarf.
    depth, fuzz = knit(1024, 30, 40)
    wool = m.diffuse(texture.mix(np.clip(0.85 * depth + 0.08 * fuzz, 0, 1), 0.25 * texture.ramp(fuzz, 0.6, 2)), ["TCS 64", "TCS 65", "TCS 61"], 3.0)
    pull = surface(body, (-0.26, -0.11, -0.46), (0.26, 0.21, -0.13), 0.003)
    scene["pullover"] = mesh.shape(
        pull,
        {
            "type": "twosided",
            "bsdf": {
                "type": "bumpmap",
                "scale": 1.0,
                "arbitrary": {
                    "type": "bitmap",
                    "raw": True,
                    "to_uv": mi.ScalarTransform4f().scale([3, 3, 1]),
                    "bitmap": mi.Bitmap((-0.004 * depth + 0.0004 * fuzz)[:, :, None].astype(np.float32)),
                },
                "bsdf": wool["bsdf"],
            },
        },
    )
    over, height = texture.weave(1024, 1024, 72, 50)
    v, u = np.meshgrid(np.arange(1024) / 1024, np.arange(1024) / 1024, indexing="ij")
    stripe_u, stripe_v = ((u * 4) % 1 < 0.35), ((v * 4) % 1 < 0.35)
    thin = np.where(over > 0.5, np.abs((u * 4) % 1 - 0.7) < 0.04, np.abs((v * 4) % 1 - 0.7) < 0.04).astype(float)
    plaid = texture.mix(np.where(over > 0.5, stripe_u, stripe_v).astype(float), thin, np.clip(0.7 * (1 - texture.ramp(height, 0.0, 0.7)), 0, 1))
    a = np.linspace(0, 2 * np.pi, 420)[None]
    w = np.linspace(0, 2 * np.pi, 120)[:, None]
    scarf = []
    for k, (z0, big, small) in enumerate(((-0.172, 0.084, 0.027), (-0.205, 0.094, 0.029))):
        crease = 1 + 0.10 * np.sin(5 * w + 3 * np.sin(2 * a + k)) + 0.06 * np.sin(9 * w + 7 * a + k)
        x = (big + small * crease * np.cos(w)) * np.cos(a)
        y = (big * 0.92 + small * crease * np.cos(w)) * np.sin(a) + 0.030
        z = z0 + small * 1.15 * crease * np.sin(w) + 0.012 * np.sin(a * (k + 1) + 1.0) + 0.020 * np.sin(a)
        scarf.append(mesh.grid(np.stack([x, y, z + 0 * x], 2), (7.0, 2.5)))
    scene["scarf"] = mesh.shape(mesh.merge(scarf), m.diffuse(plaid, ["TCS 8", "Prussian blue GDS802", "TCS 29", "TCS 44"]))
    ring = mesh.sphere(30, 60)
    scene["studs"] = mesh.shape(turned(mesh.merge([ring.move((s * 0.081, 0.006, -0.034), 0.0035) for s in (-1, 1)])), m.metal("Au", 0.08))
    # Canvas and studio.
    n1 = texture.noise(1024, 1024, 60, 1.6, 2)
    n2 = texture.noise(1024, 1024, 61, 0.7, 20)
    canvas = texture.mix(
        texture.ramp(n1 + 0.3 * n2, -1.2, 1.4), 0.6 * texture.ramp(texture.noise(1024, 1024, 62, 1.4, 3), 0, 2), 0.2 * texture.ramp(n2, 0, 2)
    )
    scene["canvas"] = mesh.shape(
        mesh.quad((-1.6, 1.15, -1.2), (3.2, 0, 0), (0, 0, 2.6)), m.diffuse(canvas, ["TCS 39", "TCS 69", "TCS 30", "TCS 63"]), False
    )
    room = [
        mesh.quad((-2.5, 1.6, -1.4), (0, -5, 0), (0, 0, 3.6)),
        mesh.quad((2.5, -3.4, -1.4), (0, 5, 0), (0, 0, 3.6)),
        mesh.quad((-2.5, -3.4, -1.4), (5, 0, 0), (0, 0, 3.6)),
        mesh.quad((-2.5, -3.4, 2.2), (5, 0, 0), (0, 5, 0)),
        mesh.quad((-2.5, -3.4, -1.4), (0, 5, 0), (5, 0, 0)),
    ]
    scene["room"] = mesh.shape(mesh.merge(room), m.diffuse(None, ["TCS 61"], gain=0.6), False)
    scene["reflector"] = mesh.shape(
        mesh.quad((0.75, -0.75, -0.7), (0, 0.9, 0), (0, 0, 1.1)), m.diffuse(None, ["Titanium dioxide GDS798 TiO2"], gain=0.95), False
    )

    def softbox(at: Any, to: Any, w_: float, h_: float) -> Mesh:
        at, to = np.asarray(at, float), np.asarray(to, float)
        d = (to - at) / np.linalg.norm(to - at)
        r = np.cross([0, 0, 1.0], d)
        r /= np.linalg.norm(r)
        up = np.cross(d, r)
        return mesh.quad(at - r * w_ / 2 - up * h_ / 2, r * w_, up * h_)

    dark = {"type": "diffuse"}
    scene["key"] = mesh.shape(softbox((-1.0, -1.05, 0.75), (0, 0, 0), 0.8, 0.9), dark, False, emitter=m.lamp("LED-B4", 5200.0))
    scene["rim"] = mesh.shape(softbox((0.85, 0.85, 0.65), (0, 0, 0), 0.25, 0.6), dark, False, emitter=m.lamp("A", 9000.0))
    scene["back"] = mesh.shape(softbox((-0.9, 0.55, -0.7), (-0.2, 1.15, -0.1), 0.3, 0.3), dark, False, emitter=m.lamp("LED-B1", 2200.0))
    return scene, {"origin": [0.05, -1.32, -0.015], "target": [0.0, 0.0, -0.055], "fov": 24.5, "aperture": 0.009, "focus": 1.235}


NAME = "portrait"
TITLE = "Portrait under LED and tungsten lamps"
WHITE: Any = "LED-B4"
DEPTH = 6
