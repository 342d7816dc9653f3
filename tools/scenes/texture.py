"""Textures: shares of materials over a square, from noise, weaves and print."""

import pathlib

import numpy as np
from PIL import Image, ImageDraw, ImageFont

FONTS = pathlib.Path("/usr/share/fonts/truetype")


def noise(rows: int, cols: int, seed: int, slope: float = 1.7, low: float = 1.0, high: float = 1e9) -> np.ndarray:
    """Periodic noise with an amplitude ∝ frequency^−slope between two frequencies (cycles per picture); mean 0, deviation 1."""
    rng = np.random.default_rng(seed)
    f = np.hypot(np.fft.fftfreq(rows)[:, None] * rows, np.fft.rfftfreq(cols)[None] * cols)
    amplitude = np.where((f >= low) & (f <= high), np.maximum(f, 1) ** -slope, 0)
    out = np.fft.irfft2(np.fft.rfft2(rng.normal(size=(rows, cols))) * amplitude, (rows, cols))
    return (out - out.mean()) / out.std()


def stretched(rows: int, cols: int, seed: int, ratio: float, slope: float = 1.4, low: float = 1.0) -> np.ndarray:
    """Noise drawn out along u by a ratio, for wood and brushed surfaces; mean 0, deviation 1."""
    rng = np.random.default_rng(seed)
    f = np.hypot(np.fft.fftfreq(rows)[:, None] * rows, np.fft.rfftfreq(cols)[None] * cols * ratio)
    out = np.fft.irfft2(np.fft.rfft2(rng.normal(size=(rows, cols))) * np.where(f >= low, np.maximum(f, 1) ** -slope, 0), (rows, cols))
    return (out - out.mean()) / out.std()


def ramp(x: np.ndarray, low: float, high: float) -> np.ndarray:
    """Smooth step from 0 to 1."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def mix(*layers: np.ndarray) -> np.ndarray:
    """Shares of n + 1 materials from n masks: each mask covers what is below it."""
    shape = layers[0].shape
    shares = [np.ones(shape)]
    for m in layers:
        shares = [s * (1 - m) for s in shares] + [m]
    return np.stack(shares, axis=2)


def bricks(rows: int, cols: int, across: int, courses: int, joint: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Mask of joints and a random number per brick; periodic, every second course displaced by half a brick."""
    v, u = np.meshgrid(np.arange(rows) / rows * courses, np.arange(cols) / cols * across, indexing="ij")
    wobble = 0.03 * noise(rows, cols, seed, 1.5, 8)
    course = np.floor(v).astype(int)
    u = u + 0.5 * (course % 2)
    number = np.floor(u).astype(int) % across
    fu, fv = u - np.floor(u), v - np.floor(v)
    edge = np.minimum(np.minimum(fu, 1 - fu) * (courses / across) * 2.4, np.minimum(fv, 1 - fv)) + wobble * 0.5
    table = np.random.default_rng(seed).random((courses, across))
    return 1 - ramp(edge, joint * 0.6, joint), table[course % courses, number]


def weave(rows: int, cols: int, threads: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Plain weave: which thread lies on top (1 warp, 0 weft) and its height (0 in the gaps)."""
    v, u = np.meshgrid(np.arange(rows) / rows * threads, np.arange(cols) / cols * threads, indexing="ij")
    u = u + 0.08 * noise(rows, cols, seed, 1.5, 4)
    v = v + 0.08 * noise(rows, cols, seed + 1, 1.5, 4)
    over = (np.floor(u) + np.floor(v)) % 2
    du, dv = np.abs(u % 1 - 0.5), np.abs(v % 1 - 0.5)
    height = np.where(over > 0.5, np.cos(np.pi * du * 0.95) * (1 - 0.35 * dv), np.cos(np.pi * dv * 0.95) * (1 - 0.35 * du))
    return over, height


class Print:
    """A drawing in several inks; becomes shares with `shares()`. Row 0 of the array is at v = 0, the bottom."""

    def __init__(self, rows: int, cols: int, inks: int, paper: int = 0) -> None:
        self.rows, self.cols, self.inks = rows, cols, inks
        self.image = Image.new("P", (cols, rows), paper)
        self.layers = [Image.new("L", (cols, rows), 255 if k == paper else 0) for k in range(inks)]

    def _apply(self, mask: Image.Image, ink: int) -> None:
        for k, layer in enumerate(self.layers):
            layer.paste(255 if k == ink else 0, (0, 0), mask)

    def text(self, x: float, y: float, words: str, size: int, ink: int, bold: bool = False, font: str = "", anchor: str = "la") -> None:
        """Text at a point (fractions of the picture from the upper left), size in samples."""
        mask = Image.new("L", (self.cols, self.rows), 0)
        name = font or ("dejavu/DejaVuSans-Bold.ttf" if bold else "dejavu/DejaVuSans.ttf")
        face = ImageFont.truetype(str(FONTS / name), size)
        ImageDraw.Draw(mask).text((x * self.cols, y * self.rows), words, fill=255, font=face, anchor=anchor)
        self._apply(mask, ink)

    def rectangle(self, x0: float, y0: float, x1: float, y1: float, ink: int, radius: float = 0) -> None:
        mask = Image.new("L", (self.cols, self.rows), 0)
        c, r = self.cols, self.rows
        ImageDraw.Draw(mask).rounded_rectangle((x0 * c, y0 * r, x1 * c, y1 * r), radius, fill=255)
        self._apply(mask, ink)

    def ellipse(self, x0: float, y0: float, x1: float, y1: float, ink: int) -> None:
        mask = Image.new("L", (self.cols, self.rows), 0)
        c, r = self.cols, self.rows
        ImageDraw.Draw(mask).ellipse((x0 * c, y0 * r, x1 * c, y1 * r), fill=255)
        self._apply(mask, ink)

    def polygon(self, points: list[tuple[float, float]], ink: int) -> None:
        mask = Image.new("L", (self.cols, self.rows), 0)
        ImageDraw.Draw(mask).polygon([(x * self.cols, y * self.rows) for x, y in points], fill=255)
        self._apply(mask, ink)

    def halftone(self, tone: np.ndarray, ink: int) -> None:
        """Covers with an ink in shares of 0 to 1 (rows × cols, first row on top)."""
        self._apply(Image.fromarray((np.clip(tone, 0, 1) * 255).astype(np.uint8)), ink)

    def shares(self) -> np.ndarray:
        stack = np.stack([np.asarray(layer, np.float32) for layer in self.layers], axis=2)[::-1] / 255
        return stack / np.maximum(stack.sum(axis=2, keepdims=True), 1e-6)
