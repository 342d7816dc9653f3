"""Spectral path tracing: eight passes of four fixed wavelengths with the same random numbers, so that bands do not get noise of their own."""

import dataclasses
import math
import time
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

BANDS = 31
GROUPS = 8
PASS_SAMPLES = 2**23


@dataclasses.dataclass
class Rendering:
    """Means over the samples of each pixel; arrays are rows × cols × (bands, bands, 3)."""

    radiance: np.ndarray
    albedo: np.ndarray
    normal: np.ndarray
    seconds: float


def stratified(random: Any, count: int, chunk: int) -> Any:
    """Positions within the pixel: one in each cell of a square grid if the number of samples is a square."""
    side = math.isqrt(chunk)
    if side * side != chunk:
        return random
    cell = dr.arange(mi.UInt32, count) % chunk
    return (mi.Vector2f(mi.Float(cell % side), mi.Float(cell // side)) + random) / side


def render(scene: Any, sensor: Any, rows: int, cols: int, spp: int, seed: int, depth: int = 8) -> Rendering:
    """Renders all bands. The wavelengths are the centres of the bands; spectra are means over the bands."""
    start = time.time()
    integrator = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 1000})
    chunk = max(1, min(spp, PASS_SAMPLES // (rows * cols)))
    passes = -(-spp // chunk)
    total = np.zeros((rows * cols, GROUPS, 8))
    normals = np.zeros((rows * cols, 3))
    for number in range(passes):
        for group in range(GROUPS):
            n = rows * cols * chunk
            sampler = mi.load_dict({"type": "independent"})
            sampler.seed(seed * 10007 + number, n)
            pixel = dr.arange(mi.UInt32, n) // chunk
            position = mi.Vector2f(mi.Float(pixel % cols), mi.Float(pixel // cols)) + stratified(sampler.next_2d(), n, chunk)
            ray, _ = sensor.sample_ray_differential(0.0, 0.5, position / mi.Vector2f(cols, rows), sampler.next_2d())
            first = dr.opaque(mi.Float, 400.0 + 40.0 * group)
            ray.wavelengths = mi.UnpolarizedSpectrum([dr.minimum(first + 10.0 * c, 700.0) for c in range(4)])
            hit = scene.ray_intersect(ray)
            albedo = hit.bsdf(ray).eval_diffuse_reflectance(hit, hit.is_valid())
            value, _, _ = integrator.sample(scene, sampler, ray)
            seen = hit.is_valid()
            lanes = [value[c] for c in range(4)] + [dr.select(seen, albedo[c], 0.0) for c in range(4)]
            lanes += [dr.select(seen, hit.sh_frame.n[c], 0.0) for c in range(3)]
            # One kernel for all of them: each reduction of an unevaluated array would trace the paths again.
            dr.eval(lanes)
            out = [dr.block_sum(lane, chunk) for lane in lanes]
            values = np.stack([np.array(o) for o in out], axis=-1)
            total[:, group] += values[:, :8]
            if group == 0:
                normals += values[:, 8:]
    total /= passes * chunk
    shape = (rows, cols, -1)
    return Rendering(
        total[:, :, :4].reshape(shape)[:, :, :BANDS].astype(np.float32),
        total[:, :, 4:].reshape(shape)[:, :, :BANDS].astype(np.float32),
        (normals / (passes * chunk)).reshape(shape).astype(np.float32),
        time.time() - start,
    )


def denoise(r: Rendering) -> np.ndarray:
    """Open Image Denoise on triplets of bands, guided by the albedo in the same bands and the normals, which have no noise."""
    import mitsuba_oidn as oidn

    triplets = [(i + 22, i + 11, i) for i in range(9)] + [(30, 20, 9), (30, 21, 10)]
    out = np.empty_like(r.radiance)
    for bands in triplets:
        pick = list(bands)
        clean = oidn.denoise(
            np.ascontiguousarray(r.radiance[:, :, pick]),
            np.ascontiguousarray(np.clip(r.albedo[:, :, pick], 0, 1)),
            np.ascontiguousarray(r.normal),
            hdr=True,
            clean_aux=True,
        )
        out[:, :, pick] = np.maximum(clean, 0.0)
    return out
