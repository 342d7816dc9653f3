"""Errors as exceptions of the fitting kind, in the words of the command."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import smalti

from conftest import Command

BAD: list[tuple[Any, type[Exception], str]] = [
    (lambda: smalti.Camera("bayr"), smalti.SmaltiError, "did you mean 'bayer'"),
    (lambda: smalti.Camera("none.toml"), FileNotFoundError, "none.toml"),
    (lambda: smalti.Camera("quad-bayer"), smalti.SmaltiError, "bayer@quad-bayer"),
    (lambda: smalti.Camera("machine-vision@rgbw"), smalti.SmaltiError, "sensor.cfa.filters.W"),
    (lambda: smalti.Camera("bayer", set={"sensor.pixel.pitch_um": -1}), smalti.SmaltiError, "sensor.pixel.pitch_um"),
    (lambda: smalti.Camera("bayer", set={"sensor.pixel.pich_um": 1}), smalti.SmaltiError, "pitch_um"),
    (lambda: smalti.Camera("bayer", set={"sensor.rows": object()}), smalti.SmaltiError, "sensor.rows"),
    (lambda: smalti.Camera.from_toml("[sensor]\nrows = 'many'"), smalti.SmaltiError, "2"),
    (lambda: smalti.Scene("macbth"), smalti.SmaltiError, "macbeth"),
    (lambda: smalti.Scene("none.exr"), FileNotFoundError, "none.exr"),
    (lambda: smalti.Scene("macbeth", luminance_cd_m2=-1), smalti.SmaltiError, "luminance_cd_m2"),
    (lambda: smalti.Scene("macbeth", illuminant="D66"), smalti.SmaltiError, "D65"),
    (lambda: smalti.Scene("macbeth", wavelengths_nm=[400, 410, 430]), smalti.SmaltiError, "even steps"),
    (lambda: smalti.Scene.from_radiance(np.zeros((3, 4))), smalti.SmaltiError, "wavelengths"),
    (lambda: smalti.Scene.from_radiance(np.zeros((3, 4, 30))), smalti.SmaltiError, "30"),
    (lambda: smalti.Scene.from_radiance(np.zeros((3, 4, 5, 6))), smalti.SmaltiError, r"\[rows, columns, wavelengths\]"),
    (lambda: smalti.Scene.from_radiance(-np.ones((3, 4, 31))), smalti.SmaltiError, "radiance"),
    (lambda: smalti.Scene.from_radiance(np.full((3, 4, 31), np.nan)), smalti.SmaltiError, "radiance"),
    (lambda: smalti.Scene.from_radiance(np.ones((0, 4, 31))), smalti.SmaltiError, "0 × 4"),
    (lambda: smalti.Spectrum([1.0, 2.0]), smalti.SmaltiError, "31"),
    (lambda: smalti.Spectrum([np.inf] * 31), smalti.SmaltiError, "finite"),
    (lambda: smalti.Spectrum([], []), smalti.SmaltiError, "at least one"),
    (lambda: smalti.Spectrum.read("none.csv"), FileNotFoundError, "none.csv"),
    (lambda: smalti.Cfa("bayr"), smalti.SmaltiError, "bayer"),
    (lambda: smalti.Cfa(["RG", "G"], {"R": "red", "G": "green"}), smalti.SmaltiError, "rectangle"),
    (lambda: smalti.Cfa(["RX"], {"R": "red"}), smalti.SmaltiError, "X"),
    (lambda: smalti.Cfa.from_arrays([[0, 9]], np.ones((2, 31))), smalti.SmaltiError, "channel"),
    (lambda: smalti.Cfa.from_arrays([[0, -1]], np.ones((2, 31))), smalti.SmaltiError, "-1"),
    (lambda: smalti.Cfa.from_arrays([[0, 1]], 2 * np.ones((2, 31))), smalti.SmaltiError, "0 to 1"),
    (lambda: smalti.RawImage(np.zeros((4, 4), int), black_level=0, white_level=1), smalti.SmaltiError, "tile"),
    (lambda: smalti.RawImage([[70000]], [[0]], black_level=0, white_level=1), smalti.SmaltiError, "70000"),
    (lambda: smalti.RawImage([[0]], [[0]], black_level=5, white_level=1), smalti.SmaltiError, "white level"),
    (lambda: smalti.RawImage.read("none.dng"), FileNotFoundError, "none.dng"),
    (lambda: smalti.Image(np.zeros((3, 4, 2))), smalti.SmaltiError, "2"),
    (lambda: smalti.Image(np.full((3, 4, 3), np.nan)), smalti.SmaltiError, "finite"),
    (lambda: smalti.Image(np.zeros((3, 4, 3)), "rgb"), smalti.SmaltiError, "linear-srgb"),  # type: ignore[arg-type]
    (lambda: smalti.Image(np.zeros((3, 4, 3))).write("a.bmp"), smalti.SmaltiError, "png"),
    (lambda: smalti.Image(np.zeros((3, 4, 3))).write("none/a.png"), FileNotFoundError, "none/a.png"),
    (lambda: smalti.OpticalImage(np.ones((3, 4, 31)), 0.0), smalti.SmaltiError, "sample_spacing_m"),
    (lambda: smalti.Pipeline.read("none.l3"), FileNotFoundError, "none.l3"),
    (lambda: smalti.Study("tabel2"), smalti.SmaltiError, "table2"),
    (lambda: smalti.Study("none.toml"), FileNotFoundError, "none.toml"),
    (lambda: smalti.Study.from_toml("colours = 3"), smalti.SmaltiError, "colors"),
    (lambda: smalti.Results("."), smalti.SmaltiError, "manifest.json"),
    (lambda: smalti.sweep("aliasing", "x", shard=(3, 2), progress=False), smalti.SmaltiError, "3/2"),
    (lambda: smalti.sweep("aliasing", "x", shard="b", progress=False), smalti.SmaltiError, "INDEX/COUNT"),
    (lambda: smalti.train(smalti.Camera("bayer"), patch=4, progress=False), smalti.SmaltiError, "3, 5, 7, 9 or 11"),
    (lambda: smalti.train(smalti.Camera("bayer"), [], progress=False), smalti.SmaltiError, "nothing to learn"),
    (lambda: smalti.delta_e([1, 2], [1, 2]), smalti.SmaltiError, "last axis is 3"),
    (lambda: smalti.edge_sfr(np.zeros((64, 64))), smalti.SmaltiError, "no edge"),
    (lambda: smalti.edge_sfr(np.full((64, 64), np.nan)), smalti.SmaltiError, "finite"),
    (lambda: smalti.evaluate(smalti.Camera("bayer"), luminance_cd_m2=0.0), smalti.SmaltiError, "luminance"),
    (lambda: smalti.compare([], pipelines=[None], progress=False), smalti.SmaltiError, "0 cameras"),
]


@pytest.mark.parametrize("number", range(len(BAD)))
def test_bad_input_is_told(number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    call, kind, words = BAD[number]
    with pytest.raises(kind, match=words) as caught:
        call()
    assert "a fault in smalti" not in str(caught.value) and "panick" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_smalti_errors_are_value_errors() -> None:
    assert issubclass(smalti.SmaltiError, ValueError) and smalti.SmaltiError.__module__ == "smalti"


def test_errors_have_the_words_of_the_command(command: Command, tmp_path: Path) -> None:
    file = tmp_path / "camera.toml"
    file.write_text('[sensor]\nrows = 480\n[sensor.pixel]\npich_um = 1.4\n')
    with pytest.raises(smalti.SmaltiError) as caught:
        smalti.Camera(file)
    said = command("simulate", file, "-o", tmp_path / "out", code=1)
    assert said.strip() == f"error: {caught.value}"
    assert "pitch_um" in str(caught.value) and ":4:" in str(caught.value)


def test_a_folder_that_holds_other_things_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(smalti.SmaltiError, match="mine.txt"):
        smalti.sweep("aliasing", tmp_path, progress=False)
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]
