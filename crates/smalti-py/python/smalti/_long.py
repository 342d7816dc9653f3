"""Long work with a progress bar of tqdm, and keyword arguments."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, Literal, Protocol, overload

from tqdm.auto import tqdm

from . import _smalti
from ._smalti import Camera, Image, Pipeline, RawImage, Results, Scene, Spectrum, Statistics, Study

Path = str | os.PathLike[str]
"""The path of a file or folder."""
Light = str | Spectrum
"""An illuminant: a name, a CSV file, or relative spectral power."""
Progress = bool | Callable[[int], object]
"""True: a progress bar on a terminal or in a notebook; False: none; or a function that is called with the number of finished steps."""


class _Told(Protocol):
    """Is called with the numbers of finished and, where it can be known, of expected steps."""

    def __call__(self, done: int, expected: int | None = None) -> object: ...


@contextmanager
def _told(progress: Progress, what: str, unit: str) -> Iterator[_Told | None]:
    if progress is False:
        yield None
    elif progress is True:
        # `disable=None`: no bar where standard error is not a terminal.
        with tqdm(desc=what, unit=unit, disable=None) as bar:

            def draw(done: int, expected: int | None = None) -> None:
                if expected != bar.total and not bar.disable:
                    # Notebooks show a new total after `reset` only, which also forgets the finished steps and the start.
                    start = bar.start_t
                    bar.reset(expected)
                    bar.start_t, bar.n, bar.last_print_n = start, done, done
                    bar.refresh()
                bar.update(done - bar.n)

            yield draw
    else:
        reported = 0

        def call(done: int, expected: int | None = None) -> None:
            nonlocal reported
            if done != reported:
                reported = done
                progress(done)

        yield call


def _gather(
    camera: Camera,
    scenes: Sequence[Scene] | None,
    pairs: Sequence[tuple[RawImage, Image]] | None,
    progress: Progress,
    *settings: Any,
) -> tuple[Statistics, _smalti.TrainingRecord]:
    of_scenes = None if scenes is None else list(scenes)
    of_pairs = None if pairs is None else list(pairs)
    with _told(progress, f"training {camera.name}", "scene") as told:
        gathered: Callable[..., tuple[Statistics, _smalti.TrainingRecord]] = _smalti.gather_statistics
        return gathered(camera, of_scenes, of_pairs, *settings, progress=told)


def gather(
    camera: Camera,
    scenes: Sequence[Scene] | None = None,
    *,
    pairs: Sequence[tuple[RawImage, Image]] | None = None,
    align: bool = True,
    illuminants: Sequence[Light] = ("D65", "A", "LED"),
    target: Literal["xyz"] | Camera = "xyz",
    target_illuminant: Light | None = None,
    exposures: Sequence[float] = (),
    patch: int = 5,
    levels: int = 10,
    level_rule: Literal["logarithmic", "noise-steps"] = "logarithmic",
    textures: Literal["none", "flat-texture", "oriented"] = "oriented",
    sharp: bool = False,
    training_set: Literal["all", "catalog"] = "all",
    seed: int = 1,
    progress: Progress = True,
) -> Statistics:
    """Gathers the statistics that a pipeline is solved from: the moments of patches and targets for each class. See `train`.

    Statistics of several runs can be merged (`Statistics.merged`) and solved with different settings (`solve`).
    """
    return _gather(
        camera, scenes, pairs, progress, align, list(illuminants), target, target_illuminant, list(exposures), patch, levels,
        level_rule, textures, sharp, training_set, seed,
    )[0]  # fmt: skip


def solve(
    statistics: Statistics,
    *,
    solver: Literal["wiener", "perceptual", "ridge", "least-squares"] = "wiener",
    alpha_flat: tuple[float, float] | None = None,
    alpha_texture: tuple[float, float] | None = None,
    linear: bool = False,
    symmetry: bool = True,
    smoothing: float = 0.0,
) -> Pipeline:
    """Solves a pipeline from statistics; the arguments are those of `train`."""
    return _smalti.solve_statistics(
        statistics, None, solver, alpha_flat, alpha_texture, linear, symmetry, smoothing, "fast"
    )


def train(
    camera: Camera,
    scenes: Sequence[Scene] | None = None,
    *,
    pairs: Sequence[tuple[RawImage, Image]] | None = None,
    align: bool = True,
    illuminants: Sequence[Light] = ("D65", "A", "LED"),
    target: Literal["xyz"] | Camera = "xyz",
    target_illuminant: Light | None = None,
    exposures: Sequence[float] = (),
    patch: int = 5,
    levels: int = 10,
    level_rule: Literal["logarithmic", "noise-steps"] = "logarithmic",
    textures: Literal["none", "flat-texture", "oriented"] = "oriented",
    sharp: bool = False,
    training_set: Literal["all", "catalog"] = "all",
    solver: Literal["wiener", "perceptual", "ridge", "least-squares"] = "wiener",
    alpha_flat: tuple[float, float] | None = None,
    alpha_texture: tuple[float, float] | None = None,
    linear: bool = False,
    symmetry: bool = True,
    smoothing: float = 0.0,
    quality: Literal["fast", "best"] = "fast",
    seed: int = 1,
    progress: Progress = True,
) -> Pipeline:
    """Learns the pipeline of a camera (L³: local, linear, learned). With default arguments, the bytes are those of `smalti train`.

    Args:
        camera: the camera, whose mosaic, noise and spectral sensitivities determine the pipeline.
        scenes: training scenes; default a built-in set, which is not used for evaluation.
        pairs: raw images with their target pictures, instead of scenes. The targets are those of the pictures: `target` and
            `target_illuminant` cannot be given.
        align: align the pictures with the raw images, from which they may be shifted or scaled; otherwise they must match pixel by pixel.
        illuminants: illuminants of the built-in set, which its scenes use in turn.
        target: "xyz", or a camera whose channels are estimated.
        target_illuminant: illuminant of the targets; default that of the scenes.
        exposures: exposures of each scene, as the response to its 99th percentile, where 1 is saturation.
        patch: side of the patch from which the colour of its central pixel is computed, pixels: 3, 5, 7, 9 or 11.
        levels: number of response levels, 1 to 256.
        level_rule: spacing of the response levels.
        textures: texture classes of patches.
        sharp: also learn to correct the blur of the lens.
        training_set: the built-in set: "all", or "catalog" without photographs and path-traced scenes.
        solver: solver of the kernels.
        alpha_flat: weight of noise relative to blur in flat patches: luminance, chrominance (implies solver="perceptual").
        alpha_texture: the same in textured patches.
        linear: learn kernels without an offset.
        symmetry: share data between positions that are equivalent by a symmetry of the mosaic.
        smoothing: share of the neighbouring levels in each kernel, from 0 (none) to 1.
        quality: "fast", one stage, or "best", whose second stage refines the picture with what lies beyond the patch. The target of
            "best" is "xyz".
        seed: seed of the noise with which patches are classified.
        progress: see `Progress`.

    Raises:
        SmaltiError: when a setting is impossible for the camera, or a position of the mosaic has no patches.
    """
    statistics, story = _gather(
        camera, scenes, pairs, progress, align, list(illuminants), target, target_illuminant, list(exposures), patch, levels,
        level_rule, textures, sharp, training_set, seed,
    )  # fmt: skip
    pipeline = _smalti.solve_statistics(
        statistics, story, solver, alpha_flat, alpha_texture, linear, symmetry, smoothing, quality
    )
    if quality == "fast":
        return pipeline
    of_scenes = None if scenes is None else list(scenes)
    of_pairs = None if pairs is None else list(pairs)
    with _told(progress, f"refining {camera.name}", "scene") as told:
        return _smalti.refine_pipeline(
            pipeline, camera, of_scenes, of_pairs, align, list(illuminants), target_illuminant, list(exposures), sharp,
            training_set, seed, told,
        )  # fmt: skip


class Comparison(list[dict[str, Any]]):
    """The records of `compare`.

    Attributes:
        verdict: for each luminance ("lights") and metric the number of the best of "contenders" and its leads over the others, in the
            unit of the metric and for CPSNR also as light, with 95 % intervals; and "crossovers", the luminances between
            which a lead changes. The "finding" of a lead is "lead", "no_difference" (the interval contains 0) or "negligible" (below the
            smallest relevant difference). Its "light" is "stops", "more_than" or "unreachable" (CPSNR stops rising with light,
            after a rise of "rise_db"); the end "high" of an interval is None where no measured light suffices with certainty.
    """

    def __init__(self, records: list[dict[str, Any]], verdict: dict[str, Any]) -> None:
        super().__init__(records)
        self.verdict = verdict


def compare(
    cameras: Sequence[Camera],
    *,
    processing: Sequence[str] = ("l3",),
    pipelines: Sequence[Pipeline | None] | None = None,
    scenes: Literal["charts", "natural", "all"] | Sequence[str | Scene] = "natural",
    luminances_cd_m2: Sequence[float] = (1.0, 80.0),
    illuminant: Light | None = None,
    exposure: float | Literal["own", "equal", "auto-equal"] = "auto-equal",
    max_saturated_percent: float = 0.5,
    max_exposure_s: float = 0.033,
    training_set: Literal["all", "catalog"] = "all",
    seed: int = 1,
    seeds: int = 3,
    cache: bool = True,
    progress: Progress = True,
) -> Comparison:
    """Compares cameras on the same scenes, as `smalti compare` does with the same defaults.

    Cameras of equal names are numbered: "1-bayer", "2-bayer".

    Args:
        cameras: one or more cameras.
        processing: kinds of processing: "l3" (a pipeline learned for each camera under the illuminant), "bilinear", "malvar2004",
            "hamilton-adams1997". A camera is left out of a kind that is not defined for its mosaic.
        pipelines: a learned pipeline for each camera; None: a pipeline is learned.
        scenes: a set of test scenes, none of which is used for training: "charts", "natural" or "all"; or built-in scenes with their
            parameters, files, and `Scene` objects. Natural scenes keep their own light; the others are relit.
        luminances_cd_m2: mean luminances of the scenes, cd/m².
        illuminant: illuminant of charts, files and targets, and of the training for them; default D65.
        exposure: a time in seconds for all pictures; "own", the time or the rule of each camera; "equal", for each scene the longest
            time at which no camera saturates more than `max_saturated_percent` of its samples, at most `max_exposure_s`; or
            "auto-equal", own times if they are the same for all cameras, otherwise equal times.
        max_saturated_percent: equal exposure: the largest share of saturated samples, percent.
        max_exposure_s: equal exposure: the longest time, s.
        training_set: the scenes that pipelines learn from; see `train`.
        seed: seed of the noise and of the training.
        seeds: number of seeds of the noise for each scene, from `seed` on.
        cache: keep optical images and statistics between runs, in the cache of the command.
        progress: see `Progress`.

    Returns:
        A list with a record for each camera, kind of processing, luminance and scene, ready for a data frame: the scores on the scene,
        of which CPSNR, ΔE2000 and S-CIELAB are means over the seeds, and MTF50, visual SNR and noise on the built-in targets. Its
        attribute `verdict` states who is better at which luminance, with 95 % intervals.
    """
    each: list[Pipeline | None] = list(pipelines) if pipelines is not None else [None] * len(cameras)
    if len(each) != len(cameras):
        raise _smalti.SmaltiError(f"pipelines: {len(each)} given for {len(cameras)} cameras; expected one for each")
    with _told(progress, "comparing", "step") as told:
        records, verdict = _smalti.compare(
            list(cameras), each, list(processing), scenes if isinstance(scenes, str) else list(scenes), list(luminances_cd_m2),
            illuminant, (exposure, max_saturated_percent / 100, max_exposure_s), training_set, (seed, seeds), cache, told,
        )  # fmt: skip
    return Comparison(records, verdict)


def light_gain(
    camera: Camera,
    other: Camera,
    *,
    pipelines: tuple[Pipeline | None, Pipeline | None] = (None, None),
    scenes: Sequence[str] | None = None,
    luminance_cd_m2: float = 1.0,
    illuminant: Light | None = None,
    seed: int = 1,
    progress: Progress = True,
) -> dict[str, Any]:
    """How much more light a camera needs to reach the scores of another, for each metric.

    Args:
        camera: the camera whose light is varied.
        other: the reference camera.
        pipelines: the learned pipelines of both, or None for the camera's own processing.
        scenes: built-in scenes with their parameters for the scores of whole pictures; default `test_scenes()`. Each is captured about
            twenty times.
        luminance_cd_m2: mean luminance of the scenes for `other`, cd/m².
        illuminant: illuminant of the scenes; default D65.
        seed: seed of the noise.
        progress: see `Progress`; steps are pictures, whose number is not known in advance.

    Returns:
        luminance_cd_m2, tried, and metrics: for each metric its name, the `gain` in stops ({"stops": v}, or {"more_than": v} or
        {"less_than": v} beyond four stops), its 95 % confidence `interval` (`low` and `high` in the same form; None for a single scene), and
        the scores of both cameras in equal light (`own`, `target`).
    """
    of = None if scenes is None else list(scenes)
    with _told(progress, f"{camera.name} against {other.name}", "picture") as told:
        return _smalti.light_gain(camera, other, pipelines, of, luminance_cd_m2, illuminant, seed, told)


class Design(dict[str, Any]):
    """The results of `design`, with the keys of the command's results.json.

    Attributes:
        camera: the camera with the colour filter array that was found.
        rivals: the camera with each published mosaic and the best filters of the same kind, by the name of the mosaic; the best first.
        front: the cameras of the compromises between the aims of the front.
    """

    def __init__(
        self, results: dict[str, Any], camera: Camera, rivals: dict[str, Camera], front: list[Camera]
    ) -> None:
        super().__init__(results)
        self.camera = camera
        self.rivals = rivals
        self.front = front


def design(
    source: Path,
    *,
    scenes: Sequence[Scene] | None = None,
    training_set: Literal["all", "catalog"] = "all",
    resume: Path | None = None,
    client: Any = None,
    progress: Progress = True,
) -> Design:
    """Finds the best colour filter array for a camera and its light, as `smalti design` does.

    The figures are expectations of a closed form, which rank arrays as learned pipelines do. `compare` scores the cameras.

    Args:
        source: a built-in design (`smalti.designs()`) or a TOML file.
        scenes: scenes to gather the statistics of light from; default those that pipelines learn from. They are relit with the
            illuminants of the design.
        training_set: the built-in scenes: "all", or "catalog" without photographs and path-traced scenes.
        resume: a folder that keeps what the search has found, so that the same call goes on there after it was stopped.
        client: a `dask.distributed.Client`, whose workers search the parts and find the same. They read `source` and the files that it names.
        progress: see `Progress`.

    Raises:
        SmaltiError: when a key or value of the design is invalid, or its rules conflict.
    """
    of = None if scenes is None else list(scenes)
    with _told(progress, f"design {os.fspath(source)}", "step") as told:
        gathered = 0

        def gather(done: int, expected: int | None = None) -> None:
            nonlocal gathered
            gathered = done
            if told is not None:
                told(done, expected)

        def find(done: int, expected: int | None = None) -> None:
            if told is not None:
                told(gathered + done, None if expected is None else gathered + expected)

        search = _smalti.DesignSearch(source, of, training_set, resume, None, gather)
        if client is not None:
            # Dask is needed only here.
            from . import _cluster

            name = os.path.abspath(source) if os.path.exists(source) else os.fspath(source)
            _cluster.design(client, name, search, find)
        # With a client, all parts are known by now.
        results, camera, rivals, front = search.find(None if client is not None else find)
    return Design(results, camera, dict(rivals), front)


@overload
def sweep(
    study: Study | Path,
    out: Path,
    *,
    client: None = None,
    shard: tuple[int, int] | str | None = None,
    part_size: int | None = None,
    cache: bool = True,
    progress: Progress = True,
) -> Results: ...


@overload
def sweep(
    study: Study | Path,
    out: Path | tuple[Any, str],
    *,
    client: Any,
    shard: None = None,
    part_size: int | None = None,
    cache: bool = True,
    progress: Progress = True,
) -> Results | None: ...


def sweep(
    study: Study | Path,
    out: Path | tuple[Any, str],
    *,
    client: Any = None,
    shard: tuple[int, int] | str | None = None,
    part_size: int | None = None,
    cache: bool = True,
    progress: Progress = True,
) -> Results | None:
    """Scores the trials of a study and writes the Parquet files of `smalti sweep`, with the same bytes.

    Existing parts are kept, so that an interrupted sweep resumes. After Ctrl-C, all finished parts are on disk.

    Args:
        study: a `Study`, the name of a built-in study, or a TOML file.
        out: a new or empty folder, or the folder of an earlier run of the same study. With a client, a folder that all workers can
            access, a URL of fsspec ("s3://bucket/results"), or (file system, path).
        client: a `dask.distributed.Client`, whose workers compute and write the parts with the same bytes. Tasks of workers that die
            are repeated.
        shard: (i, n) or "i/n": the i-th of n shards, i from 1; `merge` merges their folders.
        part_size: trials per file; default by the number of trials.
        cache: keep optical images between runs, in the cache of the command.
        progress: see `Progress`.

    Returns:
        The results in the folder; None for another file system.

    Raises:
        SmaltiError: when the folder contains other files or the results of another study.
        OSError: when the folder cannot be written.
        distributed.KilledWorker: when several workers died while computing one part.
    """
    known = study if isinstance(study, Study) else Study(study)
    if client is not None:
        if shard is not None:
            raise _smalti.SmaltiError("shard and client are given; expected only one, since workers share the whole study")
        # Dask is needed only here.
        from . import _cluster

        bar = partial(_told, progress, what=known.name, unit="trial")
        folder = _cluster.sweep(client, known, out, part_size, cache, bar)
        return Results(folder) if folder is not None else None
    if isinstance(out, tuple):
        raise _smalti.SmaltiError("out is a file system and a path; expected a folder, or also a client")
    share = _smalti.parse_shard(shard) if isinstance(shard, str) else shard
    with _told(progress, known.name, "trial") as told:
        _smalti.run_sweep(known, out, share, part_size, cache, told)
    return Results(out)


def report(
    results: Results | Path | Sequence[Results | Path],
    out: Path | None = None,
    *,
    pictures: int = 16,
    trials: Sequence[int] = (),
    draw: Sequence[str] = (),
    progress: Progress = True,
) -> dict[str, Any]:
    """Reports the results of a study as `smalti report` does: an interactive page, figures and tables.

    Args:
        results: a folder of results, or several folders for a common report.
        out: a folder for report.html, figures (SVG, PNG) and report.json, created if needed; or FILE.html for the page only; default the
            folder `report` in the first of the results.
        pictures: number of trials with learned pipelines, 0 to 1000, whose pictures are embedded in the page: the best, the worst, then those
            of the Pareto front. The page draws the pictures of every trial itself; embedded ones are for browsers without WebAssembly.
        trials: further trials of the first results, by number, whose pictures are embedded in the page.
        draw: draw figures of the conditions and processing methods whose name contains one of these texts; default the first 8.
        progress: see `Progress`; steps are pictures and figures.

    Returns:
        report.json: the tables, the best trials, the files and notes.

    Raises:
        SmaltiError: when results cannot be read, or have no design.
        OSError: when files cannot be written.
    """
    several = [results] if isinstance(results, Results | str | os.PathLike) else list(results)
    folders = [r.dir if isinstance(r, Results) else r for r in several]
    with _told(progress, "report", "figure") as told:
        return _smalti.write_report(folders, out, pictures, list(trials), list(draw), told)
