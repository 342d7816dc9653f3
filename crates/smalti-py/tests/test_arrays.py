"""Arrays in and out, at every stage; views without copies; what objects say of themselves."""

from __future__ import annotations

import gc
import io
import xml.etree.ElementTree as ET
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
import smalti
from numpy.typing import NDArray

NM = np.arange(400.0, 701.0, 10.0)


def cube(rows: int = 24, cols: int = 36) -> NDArray[np.float32]:
    return np.random.default_rng(1).random((rows, cols, len(NM)), dtype=np.float32)


def test_a_radiance_cube_comes_out_as_it_went_in() -> None:
    radiance = cube() * np.float32(1e15)
    scene = smalti.Scene.from_radiance(radiance, NM, fov_deg=4.0)
    assert scene.shape == radiance.shape
    np.testing.assert_array_equal(scene.radiance, radiance)
    np.testing.assert_allclose(scene.wavelengths_nm, NM)
    # Any memory order, any type of number.
    for same in (np.asfortranarray(radiance), radiance.astype(np.float64), radiance[::1], radiance.tolist()):
        np.testing.assert_array_equal(smalti.Scene.from_radiance(same, NM).radiance, radiance)


def test_the_luminance_is_that_of_the_standard_observer() -> None:
    import colour

    radiance = cube() * np.float32(1e15)
    joule = 6.62607015e-34 * 299792458.0 / (NM * 1e-9)
    y = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].align(colour.SpectralShape(400, 700, 10)).values[:, 1]
    expected = 683.0 * 10.0 * (radiance.astype(float) * joule * y).sum(axis=2)
    scene = smalti.Scene.from_radiance(radiance, NM)
    np.testing.assert_allclose(scene.luminance_cd_m2(), expected, rtol=1e-3)
    assert scene.mean_luminance_cd_m2 == pytest.approx(expected.mean(), rel=1e-3)
    assert smalti.Scene.from_radiance(radiance, NM, luminance_cd_m2=42.0).mean_luminance_cd_m2 == pytest.approx(42.0)
    # The same light in watts is the same scene.
    in_watts = smalti.Scene.from_radiance(radiance * joule, NM, unit="energy")
    np.testing.assert_allclose(in_watts.radiance, radiance, rtol=1e-5)


def test_reflectances_are_lit() -> None:
    scene = smalti.Scene.from_reflectance(np.full((8, 8, 31), 0.5), NM, illuminant="A", luminance_cd_m2=50.0)
    assert scene.mean_luminance_cd_m2 == pytest.approx(50.0, rel=1e-6)
    np.testing.assert_allclose(scene.radiance[3, 4] / scene.illuminant_photons.values, 0.5, rtol=1e-5)
    own = smalti.Spectrum(smalti.illuminant("A").values, NM)
    again = smalti.Scene.from_reflectance(np.full((8, 8, 31), 0.5), NM, illuminant=own, luminance_cd_m2=50.0)
    np.testing.assert_allclose(again.radiance, scene.radiance, rtol=1e-6)


def test_arrays_are_views_that_keep_their_object() -> None:
    scene = smalti.Scene.from_radiance(cube(), NM)
    first, second = scene.radiance, scene.radiance
    assert np.shares_memory(first, second) and not first.flags.owndata and not first.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        first[0, 0, 0] = 1.0
    with pytest.raises(ValueError):
        first.flags.writeable = True
    before = first.copy()
    del scene, second
    gc.collect()
    np.testing.assert_array_equal(first, before)
    picture = smalti.Image(np.zeros((4, 5, 3)))
    assert np.shares_memory(picture.array, picture.array)
    assert np.shares_memory(np.asarray(picture), picture.array)
    raw = smalti.RawImage(np.zeros((4, 6), np.uint16), [[0, 1], [1, 2]], black_level=0, white_level=255)
    assert np.shares_memory(raw.samples, raw.samples)


def test_ones_own_mosaic() -> None:
    curves = np.stack([np.exp(-0.5 * ((NM - c) / 30) ** 2) for c in (450, 550, 620)])
    cfa = smalti.Cfa.from_arrays([[2, 1], [1, 0]], curves, NM, ["B", "G", "R"], name="mine")
    assert cfa.letters == ["RG", "GB"] and cfa.name == "mine"
    np.testing.assert_array_equal(cfa.tile, [[2, 1], [1, 0]])
    np.testing.assert_allclose(cfa.channels["G"].values, curves[1])
    gaussian = {"gaussian": {"center_nm": 550, "sigma_nm": 30}}
    by_formula = smalti.Cfa(["RG", "GB"], {"R": "red", "G": gaussian, "B": cfa.channels["B"]})
    np.testing.assert_allclose(by_formula.channels["G"].values, curves[1])
    np.testing.assert_array_equal(by_formula.channels["B"].values, curves[0])
    responsivity = smalti.Camera("bayer").with_cfa(cfa).spectral_responsivity()
    ratio = responsivity / curves
    np.testing.assert_allclose(ratio, np.broadcast_to(ratio[0], ratio.shape), rtol=1e-9)


def test_a_camera_has_another_mosaic_and_tells_what_it_took() -> None:
    quad = smalti.Camera("bayer@quad-bayer")
    assert (quad.name, quad.cfa.name, quad.notes) == ("bayer@quad-bayer", "quad-bayer", [])
    np.testing.assert_array_equal(quad.spectral_responsivity(), smalti.Camera("bayer").spectral_responsivity())
    white = smalti.Camera("bayer@rgbw-sony")
    assert white.notes == ["bayer@rgbw-sony: the camera has no filter for W (white); that of the catalogue is taken"]
    # As a camera file, it stays what it is.
    assert smalti.Camera.from_toml(white.to_toml()).description == white.description


def test_filters_of_all_letters_come_from_one_file(tmp_path: Path) -> None:
    file = tmp_path / "filters.csv"
    file.write_text("nm;R;G;B\n400;0,1;0,2;0,9\n700;0,9;0,1;0,0\n")
    camera = smalti.Camera("bayer", set={"sensor.cfa.filters": {"file": str(file)}})
    assert camera.cfa.channels["R"].values[0] == pytest.approx(0.1)
    assert camera.notes == [f"{file}: columns separated by semicolons, decimal commas"]
    file.write_text("nm;R;G;B\n400;10;20;90\n700;90;10;0\n")
    with pytest.warns(UserWarning, match="values in percent"):
        cfa = smalti.Cfa("bayer", {letter: f"{file}#{letter}" for letter in "RGB"})
    assert cfa.channels["B"].values[0] == pytest.approx(0.9)


def test_every_stage_takes_arrays() -> None:
    # The irradiance below has passed no infrared cut.
    settings = {"sensor.rows": 32, "sensor.cols": 48, "exposure.time_ms": 20, "optics.ir_cut": "none"}
    camera = smalti.Camera("bayer", set=settings)
    light = smalti.illuminant("D65")
    photons = light.values * NM
    irradiance = np.full((64, 96, 31), 2e14) * photons / photons.max()
    falls = smalti.OpticalImage(irradiance, 1.5e-6)
    raw = camera.capture(falls, noise="none")
    assert raw.shape == (32, 48) and raw.samples.dtype == np.uint16
    # A flat field gives each channel one value: one's own sum over the wavelengths.
    pixel = camera.description["sensor"]["pixel"]
    electrons = (camera.spectral_responsivity() * irradiance[0, 0]).sum(axis=1) * 10.0
    electrons *= pixel["fill_factor"] * camera.pitch_m**2 * 0.020
    volts = electrons * pixel["conversion_gain_uv_per_e"] * 1e-6 * camera.description["exposure"]["analog_gain"]
    bits = camera.description["sensor"]["adc_bits"]
    expected = volts / pixel["voltage_swing_v"] * 2**bits + raw.black_level
    assert raw.tile is not None
    for channel, value in enumerate(expected):
        seen = raw.samples[:2, :2][raw.tile == channel]
        np.testing.assert_allclose(seen, value, atol=0.6)
    # Raw samples of one's own, through the same processing.
    copied = smalti.RawImage(raw.samples, camera.cfa, black_level=raw.black_level, white_level=raw.white_level)
    np.testing.assert_array_equal(camera.render(copied, "D65").array, camera.render(raw, "D65").array)
    np.testing.assert_allclose(
        raw.normalized(), (raw.samples.astype(float) - raw.black_level) / (raw.white_level - raw.black_level), atol=1e-6
    )
    shown = camera.render(raw, light).shown().array
    assert np.ptp(shown.mean(axis=(0, 1))) < 0.02


def test_raw_files_come_back(tmp_path: Path) -> None:
    photo = smalti.Camera("rgbw", set={"sensor.rows": 32, "sensor.cols": 48}).photograph(smalti.Scene("macbeth"))
    photo.raw.write(tmp_path / "a.dng")
    back = smalti.RawImage.read(tmp_path / "a.dng")
    np.testing.assert_array_equal(back.samples, photo.raw.samples)
    assert back.channel_names == photo.raw.channel_names and back.white_level == photo.raw.white_level
    volts = smalti.RawImage(np.zeros((4, 4, 2)), black_level=0.0, white_level=1.8)
    assert volts.unit == "V" and volts.shape == (4, 4, 2) and volts.normalized().shape == (4, 4, 2)


def test_pictures_come_back(tmp_path: Path) -> None:
    values = np.random.default_rng(2).integers(0, 256, (6, 7, 3), dtype=np.uint8)
    picture = smalti.Image(values)
    picture.write(tmp_path / "a.png")
    np.testing.assert_array_equal(smalti.Image.read(tmp_path / "a.png").to_uint8(), values)
    np.testing.assert_array_equal(np.round(matplotlib.image.imread(tmp_path / "a.png")[..., :3] * 255), values)
    there_and_back = picture.converted("xyz").converted("srgb")
    np.testing.assert_allclose(there_and_back.array, picture.array, atol=1e-5)
    scene = smalti.Scene("macbeth")
    scene.write(tmp_path / "a.exr")
    np.testing.assert_allclose(smalti.Scene(tmp_path / "a.exr").radiance, scene.radiance, rtol=1e-5)


def test_objects_show_themselves() -> None:
    camera = smalti.Camera("bayer")
    scene = smalti.Scene("macbeth")
    photo = camera.photograph(scene)
    for shown in (scene, photo, photo.picture):
        decoded = matplotlib.image.imread(io.BytesIO(shown._repr_png_()))
        assert decoded.ndim == 3 and decoded.std() > 0.1
    # White is white: the brightest patch of the chart is near the top of the range, and neutral.
    white = matplotlib.image.imread(io.BytesIO(scene._repr_png_()))[-24:-8, 8:24, :3].mean(axis=(0, 1))
    assert white.min() > 0.95 and np.ptp(white) < 0.02
    tiles = ET.fromstring(camera.cfa._repr_svg_())
    assert tiles.tag.endswith("svg") and len(list(tiles.iter())) > 9
    for thing, words in [
        (scene, ["macbeth", "128 × 192", "400:10:700 nm", "100 cd/m²", "photons"]),
        (camera, ["bayer", "480 × 640", "2.2 µm"]),
        (camera.cfa, ["RG/GB", "R, G, B"]),
        (photo.raw, ["digital numbers", "R, G, B"]),
        (photo.picture, ["xyz"]),
        (photo.optical_image, ["µm", "photons"]),
        (smalti.Spectrum(np.ones(31)), ["400:10:700 nm", "1"]),
        (smalti.Study("aliasing"), ["aliasing", "trials"]),
    ]:
        text = repr(thing)
        assert text.startswith("<smalti.") and all(w in text for w in words), text


def test_everything_public_is_documented() -> None:
    for name in smalti.__all__:
        thing = getattr(smalti, name)
        if name.startswith("__") or name in ("Light", "Path", "Progress"):
            continue
        assert thing.__doc__, name
        if isinstance(thing, type):
            for member in vars(thing):
                if not member.startswith("_"):
                    assert getattr(thing, member).__doc__, f"{name}.{member}"


@pytest.mark.parametrize("pattern", ["RGGB", "GRBG", "BGGR"])
def test_raw_files_through_libraw(pattern: str, tmp_path: Path) -> None:
    samples = np.random.default_rng(3).integers(0, 4096, (64, 96), dtype=np.uint16)
    tile = np.array(["RGB".index(letter) for letter in pattern]).reshape(2, 2)
    raw = smalti.RawImage(samples, tile, black_level=64, white_level=4095, channel_names=["R", "G", "B"])
    raw.write(tmp_path / "shot.dng")
    seen = smalti.read_camera_raw(tmp_path / "shot.dng")
    np.testing.assert_array_equal(seen.samples, raw.samples)
    assert seen.tile is not None and raw.tile is not None
    of = [raw.channel_names[c] for c in raw.tile.ravel()]
    assert [seen.channel_names[c] for c in seen.tile.ravel()] == of == list(pattern)
    assert (seen.black_level, seen.white_level) == (raw.black_level, raw.white_level)
    (tmp_path / "no.nef").write_bytes(b"nothing")
    with pytest.raises(smalti.SmaltiError, match="no.nef"):
        smalti.read_camera_raw(tmp_path / "no.nef")
    with pytest.raises(FileNotFoundError):
        smalti.read_camera_raw(tmp_path / "absent.nef")


def test_a_raw_file_has_the_mosaic_that_is_stated(tmp_path: Path) -> None:
    raw = smalti.RawImage(np.zeros((8, 8), np.uint16), [[0, 1], [1, 2]], black_level=0, white_level=255, channel_names=["R", "G", "B"])
    raw.write(tmp_path / "shot.dng")
    seen = smalti.RawImage.read(tmp_path / "shot.dng", cfa="CR/BC")
    assert seen.channel_names == ["C", "R", "B"]
    np.testing.assert_array_equal(seen.tile, [[0, 1], [2, 0]])
    with pytest.raises(smalti.SmaltiError, match="cfa: .*quad-bayr"):
        smalti.RawImage.read(tmp_path / "shot.dng", cfa="quad-bayr")
