"""Metrics against colour-science, NumPy and what is known."""

from __future__ import annotations

import colour
import numpy as np
import pytest
import smalti

RNG = np.random.default_rng(4)
LABS = RNG.uniform([0, -80, -80], [100, 80, 80], (2, 40, 25, 3))


@pytest.mark.parametrize(("method", "judge"), [("2000", "CIE 2000"), ("1976", "CIE 1976"), ("1994", "CIE 1994")])
def test_differences_are_those_of_colour_science(method: str, judge: str) -> None:
    expected = colour.delta_E(LABS[0], LABS[1], method=judge)
    np.testing.assert_allclose(smalti.delta_e(LABS[0], LABS[1], method), expected, rtol=1e-4)  # type: ignore[arg-type]


def test_lab_is_that_of_colour_science() -> None:
    xyz, white = RNG.random((30, 3)), (0.95, 1.0, 1.09)
    expected = colour.XYZ_to_Lab(xyz, colour.XYZ_to_xy(white))
    lab = smalti.lab_from_xyz(xyz, white)
    np.testing.assert_allclose(lab, expected, atol=1e-9)
    np.testing.assert_allclose(smalti.xyz_from_lab(lab, white), xyz, atol=1e-12)


def test_display_spaces_are_those_of_colour_science() -> None:
    rgb = RNG.random((5, 6, 3))
    expected = colour.sRGB_to_XYZ(rgb)
    np.testing.assert_allclose(smalti.Image(rgb).converted("xyz").array, expected, atol=2e-4)


def test_an_edge_of_known_response() -> None:
    """A straight edge integrated over square pixels has the response |sinc(f cos a) sinc(f sin a)| along its normal."""
    rows, cols, fine, slope = 120, 100, 8, 1 / 8
    y, x = np.mgrid[0 : rows * fine, 0 : cols * fine] / fine + 0.5 / fine
    edge = (x - cols / 2 > slope * (y - rows / 2)).astype(float)
    image = 0.1 + 0.8 * edge.reshape(rows, fine, cols, fine).mean(axis=(1, 3))
    found = smalti.edge_sfr(image)
    angle = np.arctan(slope)
    f = found.frequency_cy_per_px
    expected = np.abs(np.sinc(f * np.cos(angle)) * np.sinc(f * np.sin(angle)))
    low = f < 0.6
    np.testing.assert_allclose(found.sfr[low], expected[low], atol=0.01)
    assert abs(found.edge_angle_deg) == pytest.approx(np.degrees(angle), abs=0.05)
    assert found.mtf50_cy_per_px == pytest.approx(f[np.argmax(expected < 0.5)], rel=0.03)
    assert found.contrast == pytest.approx(0.8, rel=0.01)
    # The response of square pixels falls to one half at 0.6 cycles per pixel.
    assert found.mtf50_reliability == "beyond-nyquist"


def test_noise_and_psnr_are_those_of_numpy() -> None:
    luminance = 1 + 0.1 * RNG.standard_normal((40, 60))
    patches = [(0, 0, 20, 20), (10, 30, 25, 30)]
    percent = smalti.luminance_noise_percent(luminance, patches)
    for (r, c, h, w), value in zip(patches, percent, strict=True):
        patch = luminance[r : r + h, c : c + w].astype(np.float32).astype(float)
        assert value == pytest.approx(100 * patch.std(ddof=1) / patch.mean(), rel=1e-6)
    a, b = RNG.random((2, 20, 30, 3)).astype(np.float32)
    mse = ((a.astype(float) - b) ** 2).mean()
    assert smalti.cpsnr_db(a, b, peak=2.0) == pytest.approx(10 * np.log10(4 / mse), rel=1e-6)


def test_a_picture_is_its_own_reference() -> None:
    xyz = smalti.Image(RNG.random((32, 32, 3)), "xyz", white=(0.95, 1.0, 1.09))
    scores = smalti.score_picture(xyz, xyz)
    assert scores["scielab_mean"] == 0.0 and scores["pixel_delta_e_2000_mean"] == 0.0
    assert not smalti.scielab(xyz, xyz, (0.95, 1.0, 1.09)).any()
    assert smalti.aliasing(xyz, xyz)["total_percent"] == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(smalti.SmaltiError, match="white"):
        smalti.score_picture(xyz, smalti.Image(xyz.array, "xyz"))


def test_metrics_are_listed() -> None:
    known = {m["name"]: m for m in smalti.metrics()}
    assert known["delta_e_2000"]["better"] == "lower" and known["delta_e_2000"]["source"]
