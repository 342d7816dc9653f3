"""Long work, with a bar of tqdm: what Python says more nicely than the extension module."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, Literal, overload

from tqdm.auto import tqdm

from . import _smalti
from ._smalti import Camera, Image, Pipeline, RawImage, Results, Scene, Spectrum, Statistics, Study

Path = str | os.PathLike[str]
"""Where a file or folder is."""
Light = str | Spectrum
"""A light: a name, a CSV file, or relative spectral power."""
Progress = bool | Callable[[int], object]
"""True: a bar where somebody looks; False: none; or what is called, now and then, with the number of steps done."""


@contextmanager
def _told(progress: Progress, total: int | None, what: str, unit: str) -> Iterator[Callable[[int], object] | None]:
    if progress is False:
        yield None
    elif progress is True:
        # `disable=None`: not where nobody looks.
        with tqdm(total=total, desc=what, unit=unit, disable=None) as bar:
            yield lambda done: bar.update(done - bar.n)
    else:
        yield progress


def _after(told: Callable[[int], object], before: int, done: int) -> None:
    told(before + done)


def _gather(
    camera: Camera,
    scenes: Sequence[Scene] | None,
    pairs: Sequence[tuple[RawImage, Image]] | None,
    illuminants: Sequence[Light],
    target: Literal["xyz"] | Camera,
    target_illuminant: Light | None,
    exposures: Sequence[float],
    patch: int,
    levels: int,
    level_rule: str,
    textures: str,
    sharp: bool,
    seed: int,
    progress: Progress,
) -> tuple[Statistics, str]:
    given = len(scenes or ()) + len(pairs or ())
    total = given if scenes is not None or pairs is not None else _smalti.training_set_len()
    with _told(progress, total, f"{camera.name} learns", "scene") as told:
        return _smalti.gather_statistics(
            camera,
            None if scenes is None else list(scenes),
            None if pairs is None else list(pairs),
            list(illuminants),
            target,
            target_illuminant,
            list(exposures),
            patch,
            levels,
            level_rule,
            textures,
            sharp,
            seed,
            told,
        )


def gather(
    camera: Camera,
    scenes: Sequence[Scene] | None = None,
    *,
    pairs: Sequence[tuple[RawImage, Image]] | None = None,
    illuminants: Sequence[Light] = ("D65", "A", "LED"),
    target: Literal["xyz"] | Camera = "xyz",
    target_illuminant: Light | None = None,
    exposures: Sequence[float] = (),
    patch: int = 5,
    levels: int = 10,
    level_rule: Literal["logarithmic", "noise-steps"] = "logarithmic",
    textures: Literal["none", "flat-texture", "oriented"] = "oriented",
    sharp: bool = False,
    seed: int = 1,
    progress: Progress = True,
) -> Statistics:
    """What a camera's pipeline is learned from: the moments of patches and targets, class by class. See `train`.

    Statistics of several machines or days add up (`Statistics.merged`) and are solved in any way (`solve`).
    """
    return _gather(
        camera, scenes, pairs, illuminants, target, target_illuminant, exposures, patch, levels, level_rule, textures, sharp,
        seed, progress,
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
    """The pipeline that statistics ask for; the arguments are those of `train`."""
    return _smalti.solve_statistics(statistics, "{}", solver, alpha_flat, alpha_texture, linear, symmetry, smoothing)


def train(
    camera: Camera,
    scenes: Sequence[Scene] | None = None,
    *,
    pairs: Sequence[tuple[RawImage, Image]] | None = None,
    illuminants: Sequence[Light] = ("D65", "A", "LED"),
    target: Literal["xyz"] | Camera = "xyz",
    target_illuminant: Light | None = None,
    exposures: Sequence[float] = (),
    patch: int = 5,
    levels: int = 10,
    level_rule: Literal["logarithmic", "noise-steps"] = "logarithmic",
    textures: Literal["none", "flat-texture", "oriented"] = "oriented",
    sharp: bool = False,
    solver: Literal["wiener", "perceptual", "ridge", "least-squares"] = "wiener",
    alpha_flat: tuple[float, float] | None = None,
    alpha_texture: tuple[float, float] | None = None,
    linear: bool = False,
    symmetry: bool = True,
    smoothing: float = 0.0,
    seed: int = 1,
    progress: Progress = True,
) -> Pipeline:
    """Learns the pipeline of a camera (L³: local, linear, learned). The default is what `smalti train` learns, to the same bytes.

    Args:
        camera: whose mosaic, noise and colours the pipeline is for.
        scenes: what to learn from, simulated; default a built-in set that nothing is evaluated on.
        pairs: raw images and the pictures that should come of them, pixel by pixel, instead of scenes.
        illuminants: lights of the built-in set, in turn.
        target: "xyz", or a camera whose channels are to be estimated.
        target_illuminant: the light that targets are seen under, where it is not that of the scenes.
        exposures: exposures of each scene, as the response that its 99th percentile would have (1: just saturated).
        patch: side of the patch around a pixel that its colour is computed from, pixels: 3, 5, 7, 9 or 11.
        levels: number of response levels, 1 to 256.
        level_rule: how levels are spaced.
        textures: what is told apart by the structure within a patch.
        sharp: learn to undo the blur of the lens.
        solver: how kernels are found from the statistics.
        alpha_flat: weight of noise against blur in flat patches: luminance, chrominance (means solver="perceptual").
        alpha_texture: the same in textured patches.
        linear: kernels without an offset.
        symmetry: share data between positions that symmetry of the mosaic makes equal.
        smoothing: mix kernels with those of the neighbouring levels, 0 (not) to 1.
        seed: names the noise that patches are classified with.
        progress: see `Progress`.

    Raises:
        SmaltiError: when a setting is impossible for the camera, or a position of the mosaic has seen nothing.
    """
    statistics, story = _gather(
        camera, scenes, pairs, illuminants, target, target_illuminant, exposures, patch, levels, level_rule, textures, sharp,
        seed, progress,
    )  # fmt: skip
    return _smalti.solve_statistics(statistics, story, solver, alpha_flat, alpha_texture, linear, symmetry, smoothing)


def compare(
    cameras: Sequence[Camera],
    *,
    pipelines: Sequence[Pipeline | None] | None = None,
    scenes: Sequence[str | Scene] | None = None,
    luminances_cd_m2: Sequence[float] = (75.0,),
    illuminant: Light | None = None,
    seed: int = 1,
    progress: Progress = True,
) -> list[dict[str, Any]]:
    """Cameras before the same scenes, scored: a record for each camera, scene and luminance, ready for a data frame.

    Args:
        cameras: two or more for a comparison; one does.
        pipelines: learned pipelines, one for each camera; None in its place: the camera's own processing.
        scenes: built-in scenes with their parameters, or `Scene` objects; default `test_scenes()`, which nothing is trained on.
        luminances_cd_m2: mean luminances of the scenes, cd/m².
        illuminant: their light; default D65 for built-in scenes, their own for others.
        seed: names the noise.
        progress: see `Progress`.
    """
    each = list(pipelines) if pipelines is not None else [None] * len(cameras)
    if len(each) != len(cameras):
        raise _smalti.SmaltiError(f"pipelines: {len(each)} given for {len(cameras)} cameras; expected one for each")
    of: list[str | Scene] = list(scenes) if scenes is not None else list(_smalti.test_scenes())
    records: list[dict[str, Any]] = []
    with _told(progress, len(cameras) * len(of) * len(luminances_cd_m2), "comparing", "picture") as told:
        for camera, pipeline in zip(cameras, each, strict=True):
            step = partial(_after, told, len(records)) if told is not None else None
            scored = _smalti.score_scenes(
                camera,
                scenes=of,
                luminances_cd_m2=list(luminances_cd_m2),
                illuminant=illuminant,
                pipeline=pipeline,
                seed=seed,
                progress=step,
            )
            how = "own" if pipeline is None else "l3"
            records += [{"camera": camera.name, "processing": how, **scores.to_dict()} for scores in scored]
    return records


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
    """How much more light a camera needs to make as good pictures as another, by every metric.

    Args:
        camera: the one that gets more light, or less.
        other: the one to be equalled.
        pipelines: learned pipelines of the two; None in its place: the camera's own processing.
        scenes: built-in scenes with their parameters for the scores of whole pictures; default dead leaves and the ColorChecker. Each is
            taken some twenty times.
        luminance_cd_m2: mean luminance of the scenes for `other`, cd/m².
        illuminant: their light; default D65.
        seed: names the noise.
        progress: see `Progress`; steps are pictures, and how many it takes is not known before.

    Returns:
        luminance_cd_m2, tried, and metrics: for each its name, `gain` in stops ({"stops": v}, or {"more_than": v} or {"less_than": v} where
        it is beyond four), and what the two score in equal light (`own`, `target`).
    """
    of = None if scenes is None else list(scenes)
    with _told(progress, None, f"{camera.name} against {other.name}", "picture") as told:
        return _smalti.light_gain(camera, other, pipelines, of, luminance_cd_m2, illuminant, seed, told)


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
    """Scores the designs of a study into a folder of Parquet files: the bytes that `smalti sweep` writes.

    What is there already is kept, so that a sweep that was interrupted goes on. After Ctrl-C all finished parts are there.

    Args:
        study: a `Study`, the name of a built-in one, or a TOML file.
        out: a new or empty folder, or one that an earlier run of the same study left. With a client, a folder that all workers
            see, a URL of fsspec ("s3://bucket/results"), or (file system, path).
        client: a `dask.distributed.Client`: its workers compute the parts and write them, the same bytes. Workers that die are made up for.
        shard: (i, n) or "i/n": the i-th of n shares, i from 1; `merge` puts their folders together.
        part_size: designs of a file; default by their number.
        cache: keep optical images between runs, where the command keeps them.
        progress: see `Progress`.

    Returns:
        What is in the folder; None where a client has filled a place that is no folder.

    Raises:
        SmaltiError: when the folder holds something else, or the results of another study.
        OSError: when the folder cannot be written.
        distributed.KilledWorker: when one part has ended several workers.
    """
    known = study if isinstance(study, Study) else Study(study)
    if client is not None:
        if shard is not None:
            raise _smalti.SmaltiError("shard and client are given; expected one of them: workers share the whole study")
        # Only who has a cluster needs Dask.
        from . import _cluster

        bar = partial(_told, progress, what=known.name, unit="design")
        folder = _cluster.sweep(client, known, out, part_size, cache, bar)
        return Results(folder) if folder is not None else None
    if isinstance(out, tuple):
        raise _smalti.SmaltiError("out is a file system and a path; expected a folder, or a client whose workers write there")
    share = _smalti.parse_shard(shard) if isinstance(shard, str) else shard
    missing = _smalti.designs_missing(known, out, share, part_size)
    with _told(progress, missing, known.name, "design") as told:
        _smalti.run_sweep(known, out, share, part_size, cache, told)
    return Results(out)


def report(
    results: Results | Path | Sequence[Results | Path],
    out: Path | None = None,
    *,
    pictures: int = 16,
    designs: Sequence[int] = (),
    draw: Sequence[str] = (),
    progress: Progress = True,
) -> dict[str, Any]:
    """What a study found: a page to brush and filter, figures, tables; what `smalti report` writes.

    Args:
        results: a folder of results, or several that are shown together.
        out: a folder for report.html, figures (SVG, PNG) and report.json, made if need be; or FILE.html for the page alone; default the
            folder `report` in the first of the results.
        pictures: how many designs have pictures in the page by processing that it cannot draw itself (learned pipelines, demosaicking
            other than bilinear): the best, the worst, then of the Pareto front, 0 to 1000.
        designs: designs of the first results, by their numbers, whose pictures by the simulator are in the page.
        draw: conditions and processings that get figures of their own: those with one of these texts in their name; default the first 8.
        progress: see `Progress`; steps are what the page draws from, pictures in it and figures.

    Returns:
        report.json: the tables, the best designs, the files and notes.

    Raises:
        SmaltiError: when results cannot be read, or have no design.
        OSError: when files cannot be written.
    """
    several = [results] if isinstance(results, Results | str | os.PathLike) else list(results)
    folders = [r.dir if isinstance(r, Results) else r for r in several]
    with _told(progress, None, "report", "figure") as told:
        return _smalti.write_report(folders, out, pictures, list(designs), list(draw), told)
