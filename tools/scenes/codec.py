"""Spectral pictures as principal components (`.spc`). README.md specifies the format."""

import dataclasses
import json
import struct
import zlib

import numpy as np

MAGIC = b"SMALTSPC"
VERSION = 1
HEAD = "<8s5I4fI"


@dataclasses.dataclass
class Stored:
    """A decoded picture: radiance is rows × cols × bands."""

    radiance: np.ndarray
    start_nm: float
    step_nm: float
    light: np.ndarray
    about: dict[str, object]


def _predict(q: np.ndarray) -> np.ndarray:
    """Median edge prediction (Weinberger 1996) from left, above and above left; zero outside."""
    p = np.zeros((q.shape[0] + 1, q.shape[1] + 1), np.int64)
    p[1:, 1:] = q
    a, b, c = p[1:, :-1], p[:-1, 1:], p[:-1, :-1]
    return np.where(c >= np.maximum(a, b), np.minimum(a, b), np.where(c <= np.minimum(a, b), np.maximum(a, b), a + b - c))


def _residuals(q: np.ndarray) -> np.ndarray:
    """Residuals of the prediction as numbers from 0: even ones are positive residuals."""
    r = q - _predict(q)
    return np.where(r >= 0, 2 * r, -2 * r - 1)


def _escapes(z: np.ndarray, limit: int) -> bytes:
    rest = z.ravel()[z.ravel() >= limit] - limit
    if rest.size and rest.max() > 0xFFFF:
        raise ValueError("a residual does not fit")
    return rest.astype("<u2").tobytes()


def level_bytes(q: np.ndarray) -> bytes:
    """A byte per sample, 255 for an escape, then the escapes."""
    z = _residuals(q)
    return np.minimum(z, 255).astype(np.uint8).tobytes() + _escapes(z, 255)


def coefficient_bytes(q: np.ndarray) -> bytes:
    """A byte for two samples of neighbouring rows, nibble 15 for an escape, then the escapes in the order of the rows."""
    z = _residuals(q)
    n = np.minimum(z, 15).astype(np.uint8)
    if len(n) % 2:
        n = np.concatenate([n, np.zeros_like(n[:1])])
    return (n[0::2] | n[1::2] << 4).tobytes() + _escapes(z, 15)


def deflate(raw: bytes) -> bytes:
    """A zlib stream; the strategy suits residuals, any decoder reads it."""
    c = zlib.compressobj(9, zlib.DEFLATED, 15, 9, zlib.Z_FILTERED)
    return c.compress(raw) + c.flush()


def _unpack(raw: bytes, count: int, rows: int, cols: int) -> np.ndarray:
    z = np.empty((count, rows, cols), np.int64)
    at = 0
    for p in range(count):
        half = rows if p == 0 else (rows + 1) // 2
        data = np.frombuffer(raw, np.uint8, half * cols, at).reshape(half, cols).astype(np.int64)
        at += half * cols
        limit = 255 if p == 0 else 15
        if p == 0:
            z[p] = data
        else:
            z[p, 0::2] = data & 15
            z[p, 1::2] = (data >> 4)[: rows // 2]
        escaped = z[p] == limit
        rest = np.frombuffer(raw, "<u2", int(escaped.sum()), at)
        at += rest.nbytes
        z[p][escaped] += rest
    if at != len(raw):
        raise ValueError("the stream is too long")
    r = np.where(z & 1, -(z + 1) // 2, z // 2)
    q = np.zeros((count, rows + 1, cols + 1), np.int64)
    # The planes advance together, one sample after another, as a decoder of one plane would.
    for i in range(1, rows + 1):
        for j in range(1, cols + 1):
            a, b, c = q[:, i, j - 1], q[:, i - 1, j], q[:, i - 1, j - 1]
            low, high = np.minimum(a, b), np.maximum(a, b)
            q[:, i, j] = np.where(c >= high, low, np.where(c <= low, high, a + b - c)) + r[:, i - 1, j - 1]
    return q[:, 1:, 1:]


def encode(
    radiance: np.ndarray,
    light: np.ndarray,
    about: dict[str, object],
    components: int,
    log_step: float = 0.005,
    step: float = 0.01,
    start_nm: float = 400.0,
    step_nm: float = 10.0,
) -> bytes:
    """Stores the mean over the bands as a logarithm and the shape of the spectrum as components."""
    rows, cols, bands = radiance.shape
    level = radiance.mean(axis=2)
    floor = max(float(level.max()) * 1e-7, 1e-30)
    q0 = np.rint(np.log(np.maximum(level, floor) / floor) / log_step).astype(np.int64)
    shape = radiance / np.maximum(level, floor)[:, :, None]
    flat = shape.reshape(-1, bands).astype(np.float64)
    mean = flat.mean(axis=0)
    values, vectors = np.linalg.eigh((flat - mean).T @ (flat - mean) / len(flat))
    basis = vectors[:, ::-1][:, :components].T
    mean, basis = mean.astype("<f4"), basis.astype("<f4")
    coefficients = (flat - mean) @ basis.T.astype(np.float64)
    q = np.rint(coefficients / np.float32(step)).astype(np.int64).reshape(rows, cols, components)
    payload = deflate(level_bytes(q0) + b"".join(coefficient_bytes(q[:, :, k]) for k in range(components)))
    text = json.dumps(about, ensure_ascii=False).encode()
    head = struct.pack(HEAD, MAGIC, VERSION, rows, cols, bands, components, start_nm, step_nm, log_step, step, len(text))
    return head + struct.pack("<f", floor) + text + mean.tobytes() + basis.tobytes() + light.astype("<f4").tobytes() + payload


def decode(data: bytes) -> Stored:
    """Reads a picture back."""
    magic, version, rows, cols, bands, components, start, width, log_step, step, text = struct.unpack_from(HEAD, data)
    if magic != MAGIC or version != VERSION:
        raise ValueError("not a spectral picture of version 1")
    at = struct.calcsize(HEAD)
    (floor,) = struct.unpack_from("<f", data, at)
    at += 4
    about = json.loads(data[at : at + text])
    at += text
    numbers = np.frombuffer(data, "<f4", bands * (components + 2), at).astype(np.float64)
    at += 4 * bands * (components + 2)
    mean, basis, light = numbers[:bands], numbers[bands:-bands].reshape(components, bands), numbers[-bands:]
    q = _unpack(zlib.decompress(data[at:]), components + 1, rows, cols)
    level = np.where(q[0] == 0, 0.0, floor * np.exp(q[0] * np.float64(np.float32(log_step))))
    shape = mean + np.moveaxis(q[1:], 0, 2) * np.float64(np.float32(step)) @ basis
    return Stored((level[:, :, None] * np.maximum(shape, 0.0)).astype(np.float32), start, width, light, about)
