"""The same results as the command's."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import smalti
from numpy.typing import NDArray

import conftest
from conftest import Command, parts

STUDY = conftest.STUDY.format(sets=6, mosaics=3)


def test_scores_are_those_of_evaluate(command: Command) -> None:
    found = json.loads(command("evaluate", "rgbw", "--luminance", "20", "--json"))["cameras"][0]
    scores = smalti.evaluate(smalti.Camera("rgbw"), luminance_cd_m2=20.0)
    mine = scores.to_dict()
    assert mine == {key: found[key] for key in mine}
    assert scores.delta_e_2000 == found["delta_e_2000"]["mean"] == pytest.approx(np.mean(mine["delta_e_2000"]["per_patch"]))
    assert set(scores.pictures) == {"macbeth", "edge", "zone-plate"}
    for name in ("vora_value", "sensitivity_metamerism_index", "metamer_mismatch_percent", "mtf50_low_contrast_cy_per_mm"):
        assert getattr(scores, name) == found[name]
    # The figures are those of the pictures.
    edge = smalti.edge_sfr(scores.pictures["edge"])
    assert edge.mtf50_reliability == scores.mtf50_reliability == "reliable"
    assert edge.mtf50_cy_per_px == pytest.approx(scores.mtf50_cy_per_px, rel=0.05)


def test_captures_are_those_of_simulate(command: Command, tmp_path: Path) -> None:
    command("simulate", "bayer", "--scene", "slanted-bar", "--luminance", "30", "--stages", "-o", tmp_path)
    photo = smalti.Camera("bayer").photograph(smalti.Scene("slanted-bar", luminance_cd_m2=30.0))

    def stage(name: str) -> NDArray[np.float32]:
        array: NDArray[np.float32] = np.load(tmp_path / f"{name}.npy")
        return array

    np.testing.assert_array_equal(photo.raw.samples, stage("3-raw")[0])
    np.testing.assert_array_equal(photo.picture.array, np.moveaxis(stage("4-picture-xyz"), 0, 2))
    np.testing.assert_array_equal(photo.optical_image.irradiance, np.moveaxis(stage("2-optical-image-irradiance"), 0, 2))
    assert photo.exposure_time_s == json.loads((tmp_path / "metrics.json").read_text())["exposure_time_s"]
    photo.raw.write(tmp_path / "own.dng")
    assert (tmp_path / "own.dng").read_bytes() == (tmp_path / "raw.dng").read_bytes()


def test_sweeps_write_the_same_bytes(command: Command, tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(STUDY)
    command("sweep", tmp_path / "study.toml", "-o", tmp_path / "by-command", "--part-size", "8")
    told: list[int] = []
    results = smalti.sweep(tmp_path / "study.toml", tmp_path / "here", part_size=8, progress=told.append)
    assert results.complete and len(results) == 72
    assert told == sorted(told) and (not told or told[-1] <= 72)
    expected = parts(tmp_path / "by-command")
    assert parts(tmp_path / "here") == expected and len(expected) == 9
    # Shards, by either of them; each goes on from what the other left.
    smalti.sweep(tmp_path / "study.toml", tmp_path / "one", shard=(1, 2), part_size=8, progress=False)
    command("sweep", tmp_path / "study.toml", "-o", tmp_path / "two", "--part-size", "8", "--shard", "2/2")
    smalti.merge([tmp_path / "one", tmp_path / "two"], tmp_path / "merged")
    assert parts(tmp_path / "merged") == expected
    one = smalti.sweep(tmp_path / "study.toml", tmp_path / "one", part_size=8, progress=False)
    assert one.complete and parts(tmp_path / "one") == expected


def test_results_are_those_of_the_files(tmp_path: Path) -> None:
    import pandas as pd

    study = smalti.Study.from_toml(STUDY)
    results = smalti.sweep(study, tmp_path / "out", part_size=16, progress=False)
    frame, files = results.to_pandas(), pd.read_parquet(tmp_path / "out" / "trials")
    assert list(frame) == list(files) and len(frame) == len(study) == 72
    for name in frame:
        if frame[name].dtype == np.float64:
            np.testing.assert_array_equal(frame[name], files[name])
    unit, meaning = results.columns["delta_e_2000"]
    assert unit == "ΔE00" and meaning
    results.verify()
    # A trial is what the table says it is.
    row = frame.iloc[40]
    assert len(study.cfa(40).channel_names) == row.colors
    part = sorted((tmp_path / "out" / "trials").iterdir())[0]
    part.write_bytes(part.read_bytes()[:-9])
    with pytest.raises(smalti.SmaltiError, match=part.name):
        results.verify()


def test_pipelines_are_those_of_train(command: Command, tmp_path: Path) -> None:
    small = {"sensor.rows": 96, "sensor.cols": 128}
    camera = smalti.Camera("bayer", set=small)
    options = ["--set", "sensor.rows=96", "--set", "sensor.cols=128", "--patch", "3", "--levels", "3", "--textures", "none"]
    names = ["grey-steps", "dead-leaves?rows=128&cols=192&seed=4"]
    scenes = [option for name in names for option in ("--scene", name)]
    command("train", "bayer", *options, *scenes, "-o", tmp_path / "command.l3")
    given = [smalti.Scene(name) for name in names]
    pipeline = smalti.train(camera, given, patch=3, levels=3, textures="none", progress=False)
    pipeline.write(tmp_path / "here.l3")
    assert (tmp_path / "here.l3").read_bytes() == (tmp_path / "command.l3").read_bytes()
    photo = camera.photograph(smalti.Scene("macbeth"))
    photo.raw.write(tmp_path / "raw.dng")
    command("render", tmp_path / "raw.dng", "--pipeline", tmp_path / "here.l3", "-o", tmp_path / "out.npy")
    rendered = pipeline.render(photo.raw)
    np.testing.assert_array_equal(rendered.array, np.moveaxis(np.load(tmp_path / "out.npy"), 0, 2))
    # The built-in training set is the same, too: its scenes and lights, in their order.
    shown = command("train", "--help")
    assert "[default: D65,A,LED]" in shown
    again = smalti.Pipeline.read(tmp_path / "here.l3")
    np.testing.assert_array_equal(again.weights, pipeline.weights)


def test_the_command_comes_with_the_package(command: Command, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert command("--version") == f"smalti {smalti.__version__}\n"
    assert smalti.command(["show", "rgbw", "-o", tmp_path / "rgbw.svg"]) == 0
    assert (tmp_path / "rgbw.svg").read_text().startswith("<svg")
    assert smalti.command(["evaluate", "nikon"]) == 1 and "nikon" in capfd.readouterr().err
    assert smalti.command(["evaluate"]) == 2 and smalti.command(["--help"]) == 0
    assert smalti.command([]) == 2


def test_reports_are_those_of_the_command(command: Command, tmp_path: Path) -> None:
    results = smalti.sweep(smalti.Study.from_toml(STUDY), tmp_path / "out", progress=False)
    seen: list[int] = []
    document = smalti.report(results, trials=[1, 7], progress=seen.append)
    # What the page draws from, two pictures of each of two trials; a figure is an SVG and a PNG.
    assert seen[-1] == 1 + 4 + len(document["figures"]) / 2
    assert document == json.loads((tmp_path / "out/report/report.json").read_text())
    assert document == json.loads(command("report", tmp_path / "out", "-o", tmp_path / "other", "--picture", "1,7", "--json"))
    assert (tmp_path / "out/report/report.html").read_bytes() == (tmp_path / "other/report.html").read_bytes()
    smalti.report([tmp_path / "out"], tmp_path / "alone.html", pictures=0)
    assert (tmp_path / "alone.html").read_bytes().startswith(b"<!doctype html>")
    with pytest.raises(smalti.SmaltiError, match="no condition has 'sepia' in its name"):
        smalti.report(results, tmp_path / "drawn", draw=["sepia"])
    with pytest.raises(smalti.SmaltiError, match="none holds no results"):
        smalti.report(tmp_path / "none")
    # A trial goes on as a camera.
    frame = results.to_pandas()
    scores = smalti.evaluate(results.camera(40), luminance_cd_m2=frame.luminance_cd_m2[40], cache=False)
    assert scores.delta_e_2000 == pytest.approx(frame.delta_e_2000[40], rel=1e-6)
    with pytest.raises(smalti.SmaltiError, match="trials 0 to 71, not 72"):
        results.camera(72)


SIZE = {"sensor.rows": 64, "sensor.cols": 96}
SET = ["--set", "sensor.rows=64", "--set", "sensor.cols=96"]
SCENES = ["dead-leaves?rows=64&cols=96&largest=40", "macbeth?patch=12"]


def test_training_gives_the_bytes_of_train(command: Command, tmp_path: Path) -> None:
    listed = [word for scene in SCENES for word in ("--scene", scene)]
    few = ["--patch", "3", "--levels", "3", "--textures", "none", "--seed", "5"]
    command("train", "bayer", *listed, *few, *SET, "-o", tmp_path / "command.l3")
    pipeline = smalti.train(
        smalti.Camera("bayer", set=SIZE), [smalti.Scene(s) for s in SCENES], patch=3, levels=3, textures="none", seed=5,
        progress=False,
    )  # fmt: skip
    pipeline.write(tmp_path / "python.l3")
    assert (tmp_path / "python.l3").read_bytes() == (tmp_path / "command.l3").read_bytes()
    assert pipeline.provenance["settings"]["textures"] == "none" and pipeline.provenance["scenes"] == SCENES


def test_comparisons_are_those_of_compare(command: Command, tmp_path: Path) -> None:
    listed = [word for scene in SCENES for word in ("--scene", scene)]
    words = ["--processing", "bilinear", *listed, *SET, "--seeds", "1", "-o", tmp_path / "o", "--json"]
    results = json.loads(command("compare", "bayer", "rgbw", *words))["results"]
    found = [(r["camera"], r["luminance_cd_m2"], s["scene"], s["scores"]) for r in results for s in r["scenes"]]
    cameras = [smalti.Camera(name, set=SIZE) for name in ("bayer", "rgbw")]
    records = smalti.compare(cameras, processing=["bilinear"], scenes=SCENES, seeds=1, progress=False)
    assert len(found) == len(records) == 8
    own = {(r["camera"], r["luminance_cd_m2"], r["scene"]): r for r in records}
    for camera, luminance, scene, scores in found:
        record = own[camera, luminance, scene]
        assert scores == {key: record[key] for key in scores}


class Bar:
    """What a progress bar shows."""

    n, last_print_n, start_t, disable = 0, 0, 0.0, False
    total: int | None = None

    def __enter__(self) -> Bar:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def reset(self, total: int) -> None:
        self.n, self.total = 0, total

    def refresh(self) -> None:
        pass

    def update(self, more: int) -> None:
        self.n += more


def test_the_bar_of_a_comparison_counts_its_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    camera = smalti.Camera("bayer", set=SIZE)
    pipeline = smalti.train(camera, [smalti.Scene(s) for s in SCENES], patch=3, levels=3, textures="none", progress=False)
    bar = Bar()
    monkeypatch.setattr("smalti._long.tqdm", lambda **_: bar)
    smalti.compare(
        [camera], processing=["l3", "bilinear"], pipelines=[pipeline], scenes=SCENES, luminances_cd_m2=[40.0, 80.0], cache=False,
    )  # fmt: skip
    # Targets and each scene, for each kind of processing at each luminance. A given pipeline is no step.
    steps = 2 * 2 * (1 + len(SCENES))
    assert (bar.n, bar.total) == (steps, steps)


def test_a_name_alone_is_that_of_the_test_set(command: Command, tmp_path: Path) -> None:
    whole = next(s for s in smalti.test_scenes() if s.split("?")[0] == "macbeth")
    (record,) = smalti.compare([smalti.Camera("bayer")], processing=["bilinear"], scenes=["macbeth"], luminances_cd_m2=[75.0], progress=False)
    assert record["scene"] == whole


def test_photographs_are_scored_as_simulate_scores_them(command: Command, tmp_path: Path) -> None:
    words = ["--scene", "macbeth?patch=12", "--luminance", "30", *SET, "-o", tmp_path / "o", "--json"]
    picture = json.loads(command("simulate", "bayer", *words))["picture"]
    photo = smalti.Camera("bayer", set=SIZE).photograph(smalti.Scene("macbeth?patch=12", luminance_cd_m2=30.0))
    scores = photo.scores()
    assert scores is not None
    for key in ("cpsnr_db", "pixel_delta_e_2000_mean", "pixel_delta_e_2000_p95", "scielab_mean"):
        assert picture[key] == scores[key]
