"""Meshes made of arrays, written as PLY for the renderer."""

import dataclasses
import pathlib
import tempfile
from typing import Any

import numpy as np

_FOLDER = pathlib.Path(tempfile.mkdtemp(prefix="scenes-"))
_COUNT = [0]


@dataclasses.dataclass
class Mesh:
    """Vertices (n × 3, metres), triangles (m × 3), texture coordinates (n × 2)."""

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray

    def move(self, offset: Any, scale: Any = 1.0, turn_z: float = 0.0) -> "Mesh":
        """Scaled, turned about z (radians), then moved."""
        v = self.vertices * np.asarray(scale)
        return Mesh(v @ rotation_z(turn_z).T + np.asarray(offset, float), self.faces, self.uv)

    def turn(self, matrix: np.ndarray) -> "Mesh":
        """Turned by a matrix."""
        return Mesh(self.vertices @ matrix.T, self.faces, self.uv)


def rotation_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def rotation_x(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0, 0], [0, c, -s], [0, s, c]])


def merge(meshes: list[Mesh]) -> Mesh:
    """One mesh of several."""
    offsets = np.cumsum([0] + [len(m.vertices) for m in meshes])
    return Mesh(
        np.concatenate([m.vertices for m in meshes]),
        np.concatenate([m.faces + o for m, o in zip(meshes, offsets)]),
        np.concatenate([m.uv for m in meshes]),
    )


def grid(points: np.ndarray, uv_scale: tuple[float, float] = (1.0, 1.0)) -> Mesh:
    """A surface of points (rows × cols × 3); u follows the columns, v the rows."""
    rows, cols = points.shape[:2]
    i = np.arange(rows * cols).reshape(rows, cols)
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel(), i[1:, :-1].ravel()
    v, u = np.meshgrid(np.linspace(0, uv_scale[1], rows), np.linspace(0, uv_scale[0], cols), indexing="ij")
    return Mesh(points.reshape(-1, 3), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]), np.stack([u.ravel(), v.ravel()], 1))


def quad(origin: Any, edge_u: Any, edge_v: Any, uv: tuple[float, float, float, float] = (0, 0, 1, 1)) -> Mesh:
    """A parallelogram; uv is (u0, v0, u1, v1)."""
    o, a, b = (np.asarray(x, float) for x in (origin, edge_u, edge_v))
    u0, v0, u1, v1 = uv
    return Mesh(np.array([o, o + a, o + a + b, o + b]), np.array([[0, 1, 2], [0, 2, 3]]), np.array([[u0, v0], [u1, v0], [u1, v1], [u0, v1]]))


def box(low: Any, high: Any, cells: list[tuple[float, float, float, float]] | None = None) -> Mesh:
    """A box: faces front (−y), right (+x), back, left, top, bottom, each with a uv cell (whole texture if absent)."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    w, d, h = x1 - x0, y1 - y0, z1 - z0
    c = cells or [(0, 0, 1, 1)] * 6
    return merge(
        [
            quad((x0, y0, z0), (w, 0, 0), (0, 0, h), c[0]),
            quad((x1, y0, z0), (0, d, 0), (0, 0, h), c[1]),
            quad((x1, y1, z0), (-w, 0, 0), (0, 0, h), c[2]),
            quad((x0, y1, z0), (0, -d, 0), (0, 0, h), c[3]),
            quad((x0, y0, z1), (w, 0, 0), (0, d, 0), c[4]),
            quad((x0, y1, z0), (w, 0, 0), (0, -d, 0), c[5]),
        ]
    )


def lathe(profile: np.ndarray, sides: int = 96) -> Mesh:
    """A surface of revolution about z; the profile is n × 2, radius and height."""
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    r, z = profile[:, 0][:, None], profile[:, 1][:, None]
    return grid(np.stack([r * np.cos(angle), r * np.sin(angle), np.broadcast_to(z, (len(profile), sides + 1))], 2))


def sphere(rows: int = 96, cols: int = 192) -> Mesh:
    """A unit sphere, v from the south pole to the north pole."""
    t = np.linspace(-np.pi / 2, np.pi / 2, rows)[:, None]
    p = np.linspace(0, 2 * np.pi, cols)
    return grid(np.stack([np.cos(t) * np.cos(p), np.cos(t) * np.sin(p), np.sin(t) * np.ones_like(p)], 2))


def tube(path: np.ndarray, radius: np.ndarray, sides: int = 8) -> Mesh:
    """A tube about a path (n × 3) with a radius at each point."""
    t = np.gradient(path, axis=0)
    t /= np.linalg.norm(t, axis=1, keepdims=True) + 1e-12
    ref = np.where(np.abs(t[:, 2:3]) < 0.9, [[0, 0, 1.0]], [[1.0, 0, 0]])
    a = np.cross(t, ref)
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    b = np.cross(t, a)
    w = np.linspace(0, 2 * np.pi, sides + 1)
    ring = a[:, None] * np.cos(w)[None, :, None] + b[:, None] * np.sin(w)[None, :, None]
    return grid(path[:, None] + ring * np.asarray(radius)[:, None, None])


def shape(mesh: Mesh, bsdf: dict[str, Any], smooth: bool = True, **more: Any) -> dict[str, Any]:
    """The mesh as a shape of Mitsuba, by way of a temporary PLY file."""
    v = mesh.vertices
    f = mesh.faces
    corner = v[f]
    n = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normals = np.zeros_like(v)
    for k in range(3):
        np.add.at(normals, f[:, k], n)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-20
    rows = np.concatenate([v, normals, mesh.uv], axis=1).astype("<f4")
    _COUNT[0] += 1
    path = _FOLDER / f"{_COUNT[0]}.ply"
    names = ["x", "y", "z", "nx", "ny", "nz", "u", "v"]
    head = "ply\nformat binary_little_endian 1.0\n" + f"element vertex {len(v)}\n"
    head += "".join(f"property float {name}\n" for name in names)
    head += f"element face {len(f)}\nproperty list uchar int vertex_indices\nend_header\n"
    cells = np.empty(len(f), np.dtype([("n", "u1"), ("i", "<i4", 3)]))
    cells["n"], cells["i"] = 3, f
    path.write_bytes(head.encode() + rows.tobytes() + cells.tobytes())
    return {"type": "ply", "filename": str(path), "face_normals": not smooth, "bsdf": bsdf, **more}
