"""Pipelines from scenes, from pairs and from sums of statistics; renderings against NumPy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import smalti

SMALL = {"sensor.rows": 64, "sensor.cols": 96}


def scenes() -> list[smalti.Scene]:
    names = ["dead-leaves?rows=128&cols=192&seed=%d" % s for s in (1, 2)]
    return [smalti.Scene(name) for name in [*names, "grey-steps?steps=8&step=24&rows=128"]]


def test_learn_and_render() -> None:
    camera = smalti.Camera("rgbw", set=SMALL)
    told: list[int] = []
    pipeline = smalti.train(camera, scenes(), patch=3, levels=4, textures="none", progress=told.append)
    assert told == sorted(told) and all(n <= 3 for n in told)
    photo = camera.photograph(smalti.Scene("macbeth"), noise="none")
    rendered = pipeline.render(photo.raw)
    reference = photo.reference()
    # Reading all pixels, the reference is that of the camera itself.
    whole = camera.photograph(smalti.Scene("macbeth"), full_frame=True)
    own = camera.reference(whole.optical_image, smalti.Scene("macbeth"), time_s=whole.exposure_time_s)
    np.testing.assert_array_equal(whole.reference().array, own.array)
    # A wrong white or a channel in the wrong place costs more.
    assert smalti.score_picture(rendered, reference)["pixel_delta_e_2000_mean"] < 5.0
    assert rendered.space == "xyz" and rendered.white == pytest.approx(reference.white, rel=1e-6)
    assert pipeline.channel_names == ["R", "G", "W", "B"] and pipeline.outputs == ["X", "Y", "Z"]
    values, unlike = pipeline.render_outputs(photo.raw)
    np.testing.assert_array_equal(values, rendered.array)
    assert set(unlike) == {"darker", "brighter", "saturation"}
    assert pipeline.weights.shape[-3:] == (3, 3, 3) and pipeline.weights.shape[0] == 4
    assert len(pipeline.classes()) == int(np.prod(pipeline.weights.shape[:4]))
    assert pipeline.provenance["camera"]["name"] == "rgbw"


def test_statistics_add_up() -> None:
    camera = smalti.Camera("bayer", set=SMALL)
    first, second = scenes()[:2]
    settings = {"patch": 3, "levels": 3, "textures": "none", "progress": False}
    a, b = smalti.gather(camera, [first], **settings), smalti.gather(camera, [second], **settings)  # type: ignore[arg-type]
    both = a.merged(b)
    assert both.patches == a.patches + b.patches and a.outputs == ["X", "Y", "Z"]
    sums, at_once = smalti.solve(both), smalti.solve(b.merged(a))
    np.testing.assert_allclose(sums.weights, at_once.weights, atol=1e-6)


def test_pairs_are_fitted_as_numpy_fits_them() -> None:
    """One class, no noise: the kernels are those of least squares."""
    rng = np.random.default_rng(3)
    camera = smalti.Camera("bayer", set=SMALL)
    samples = rng.integers(200, 3000, (64, 96)).astype(np.uint16)
    raw = smalti.RawImage(samples, camera.cfa, black_level=0, white_level=16383)
    target = smalti.Image(rng.random((64, 96, 3)), "xyz", white=(0.95, 1.0, 1.09))
    pipeline = smalti.train(
        camera, pairs=[(raw, target)], align=False, patch=3, levels=1, textures="none", solver="least-squares", symmetry=False,
        progress=False,
    )  # fmt: skip
    with pytest.raises(smalti.SmaltiError, match="the targets of pairs are their pictures"):
        smalti.train(camera, pairs=[(raw, target)], target_illuminant="A", progress=False)
    values = raw.normalized()
    # Patches at even rows and columns within the borders: red cells.
    at = [(r, c) for r in range(2, 62, 2) for c in range(2, 94, 2)]
    patches = np.array([values[r - 1 : r + 2, c - 1 : c + 2].ravel() for r, c in at])
    design = np.column_stack([patches, np.ones(len(at))])
    wanted = np.array([target.array[r, c] for r, c in at])
    solved, *_ = np.linalg.lstsq(design, wanted, rcond=None)
    seen = pipeline.render(raw).array
    fitted = design @ solved
    rendered = np.array([seen[r, c] for r, c in at])
    # The pipeline also learns from the border, which is mirrored.
    assert np.abs(rendered - fitted).mean() < 0.1 * np.abs(fitted - fitted.mean(axis=0)).mean() + 0.02


def test_a_learned_pipeline_renders_a_photograph() -> None:
    camera = smalti.Camera("bayer", set=SMALL)
    scene = smalti.Scene("dead-leaves?rows=64&cols=96&largest=40")
    pipeline = smalti.train(camera, [scene], patch=3, levels=3, textures="none", progress=False)
    own = camera.photograph(scene, noise="none")
    learned = camera.photograph(scene, noise="none", pipeline=pipeline)
    np.testing.assert_array_equal(own.raw.samples, learned.raw.samples)
    scores, classic = learned.scores(), own.scores()
    assert scores is not None and classic is not None and scores["cpsnr_db"] > classic["cpsnr_db"]
    # A scene at other wavelengths is on the scale of the pipeline.
    wide = smalti.Scene("dead-leaves?rows=64&cols=96&largest=40", wavelengths_nm=np.arange(380.0, 781.0, 10.0))
    there = camera.photograph(wide, noise="none", pipeline=pipeline)
    assert there.reference().array.mean() == pytest.approx(learned.reference().array.mean(), rel=0.002)
    with pytest.raises(smalti.SmaltiError, match="the pipeline is for 2 × 2"):
        smalti.Camera("rgbw", set=SMALL).photograph(scene, pipeline=pipeline)


def test_a_pipeline_refuses_another_mosaic() -> None:
    pipeline = smalti.train(smalti.Camera("bayer", set=SMALL), scenes()[:1], patch=3, levels=1, progress=False)
    other = smalti.Camera("kodak", set=SMALL).photograph(smalti.Scene("macbeth"))
    with pytest.raises(smalti.SmaltiError):
        pipeline.render(other.raw)


def test_compare_gives_records() -> None:
    import pandas as pd

    cameras = [smalti.Camera("bayer"), smalti.Camera("rgbw")]
    told: list[int] = []
    records = smalti.compare(cameras, processing=["bilinear"], scenes=["macbeth?patch=32"], luminances_cd_m2=[5.0, 50.0], progress=told.append)
    frame = pd.DataFrame(records).set_index(["camera", "luminance_cd_m2"])
    assert len(frame) == 4 and told == sorted(told)
    assert (frame.cpsnr_db.xs(50.0, level=1) > frame.cpsnr_db.xs(5.0, level=1)).all()


def test_compare_takes_any_scene() -> None:
    def of(scene: smalti.Scene, illuminant: str = "D65") -> dict[str, Any]:
        (record,) = smalti.compare(
            [smalti.Camera("bayer")], processing=["bilinear"], scenes=[scene], illuminant=illuminant, luminances_cd_m2=[20.0],
            progress=False,
        )  # fmt: skip
        return record

    scene = smalti.Scene("macbeth?patch=32", illuminant="A")
    own, relit = of(scene, "A"), of(scene)
    assert own["scene"] == "macbeth?patch=32" and own["cpsnr_db"] != relit["cpsnr_db"]
    assert own["cpsnr_db"] > 20 and own["seed"] == 1
    # On wavelengths of its own.
    fine = of(smalti.Scene("macbeth?patch=32", wavelengths_nm=np.arange(400, 701, 5)))
    assert fine["cpsnr_db"] == pytest.approx(relit["cpsnr_db"], abs=0.5)


def test_a_stop_of_aperture_is_a_stop_of_light() -> None:
    scenes = ["dead-leaves?rows=96&cols=128&least=4&largest=40&seed=3"]
    wide, narrow = smalti.Camera("bayer"), smalti.Camera("bayer", set={"optics.f_number": 4 * 2**0.5})
    seen: list[int] = []
    same = smalti.light_gain(wide, wide, scenes=scenes, progress=seen.append)
    # In equal light for both cameras, and a stop on either side of it for the intervals.
    assert seen == sorted(seen) and same["tried"] == 3 and seen[-1] % 4 == 0
    assert all(m["gain"] == {"stops": 0.0} and m["own"] == m["target"] for m in same["metrics"])
    gain = {m["metric"]: m["gain"]["stops"] for m in smalti.light_gain(narrow, wide, scenes=scenes)["metrics"]}
    assert gain["visual_snr"] == pytest.approx(1, abs=0.1) and gain["cpsnr_db"] == pytest.approx(1, abs=0.2)


def test_best_quality_refines_pictures(tmp_path: Path) -> None:
    camera = smalti.Camera("bayer", set=SMALL)
    # A second stage needs to have seen what it refines: uniform colours as dark as the picture.
    patches = [f"color-patches?rows=128&cols=192&seed={seed}&least=40" for seed in (1, 2, 3, 4, 9)]
    learned_from = [smalti.Scene(name) for name in patches[:4]]
    settings = {"exposures": [0.1, 0.03, 0.01, 0.004], "levels": 4, "progress": False}
    fast = smalti.train(camera, learned_from, **settings)  # type: ignore[arg-type]
    told: list[int] = []
    best = smalti.train(camera, learned_from, quality="best", **{**settings, "progress": told.append})  # type: ignore[arg-type]
    # Each scene is a step of either stage.
    assert max(told) == 4
    np.testing.assert_array_equal(best.weights, fast.weights)
    assert best.provenance["training"]["quality"] == "best"
    photo = camera.photograph(smalti.Scene(patches[4], luminance_cd_m2=1.0))
    reference = photo.reference()
    errors = [smalti.score_picture(p.render(photo.raw), reference)["pixel_delta_e_2000_mean"] for p in (fast, best)]
    assert errors[1] < 0.95 * errors[0]
    assert (fast.quality, best.quality) == ("fast", "best")
    assert "of quality best" in repr(best)
    np.testing.assert_array_equal(best.at_quality("fast").render(photo.raw).array, fast.render(photo.raw).array)
    with pytest.raises(smalti.SmaltiError, match="one stage"):
        fast.at_quality("best")
    single, fixed = (best.render(photo.raw, fixed_point=in_integers).array for in_integers in (False, True))
    # Pictures have 20 binary places. After inputs, roots and smooth pictures have been rounded, less than two units of the last are lost.
    assert np.sqrt(np.mean((single - fixed) ** 2)) < 2 * 2.0**-20
    for arithmetic, number in (("integers", "int16_t"), ("float", "float")):
        best.write(tmp_path / "best.h", arithmetic=arithmetic)  # type: ignore[arg-type]
        assert f"static const {number} best_refined_kernels" in (tmp_path / "best.h").read_text()
    with pytest.raises(ValueError, match="arithmetic"):
        best.write(tmp_path / "best.h", arithmetic="double")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="quality"):
        smalti.train(camera, learned_from, quality="good", progress=False)  # type: ignore[arg-type]
