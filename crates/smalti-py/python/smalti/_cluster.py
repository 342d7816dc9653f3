"""Sweeps and searches on the workers of a Dask cluster. Workers compute and write the parts of a sweep and report only their completion; those of a search
return what they found."""

from __future__ import annotations

import os
import secrets
import threading
import time
from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any

import distributed
from fsspec.core import url_to_fs  # type: ignore[import-untyped]
from fsspec.implementations.local import LocalFileSystem  # type: ignore[import-untyped]

from ._smalti import DesignSearch, PartMaker, SharedFolder, SharedPlace, SmaltiError, Study, scenes_in_files

RETRIES = 3
"""Number of retries of a part that could not be written. Dask itself counts the workers that die."""
AHEAD = 4
"""Number of parts that are submitted for each thread of the workers, so that no thread waits; more would burden the scheduler."""
PATIENCE = 1.0
"""Interval, in s, at which the number of workers is queried."""

Target = str | tuple[Any, str]
"""A folder that every worker can access, or a file system of fsspec and a path in it."""
Open = Callable[[], Any]
"""Opens the progress of trials."""


class _RemoteDataset:
    """Another file system of fsspec."""

    def __init__(self, study: Study, fs: Any, root: str, part_size: int | None) -> None:
        self._fs, self._root, self._parts = fs, root, 0
        fs.invalidate_cache()
        names = self._names(root)
        there = fs.cat_file(f"{root}/manifest.json") if "manifest.json" in names else None
        where = str(fs.unstrip_protocol(root))
        self._place = SharedPlace(study, where, part_size, names, there)
        self.manifest = self._place.manifest
        self.trials_of = self._place.trials_of
        self._missing = self._place.missing(self._names(f"{root}/trials"))
        if there is None:
            fs.makedirs(f"{root}/trials", exist_ok=True)
            _put(fs, f"{root}/manifest.json", self.manifest().encode())

    def _names(self, folder: str) -> list[str]:
        try:
            found = self._fs.ls(folder, detail=False)
        except FileNotFoundError:
            return []
        # Object stores may list the folder itself.
        return [str(f).rstrip("/").rsplit("/", 1)[-1] for f in found if str(f).strip("/") != folder.strip("/")]

    def missing(self) -> list[int]:
        return self._missing

    def adopt(self, part: int) -> None:
        self._parts += 1

    def finish(self, seconds: float, threads: int) -> None:
        if self._parts > 0:
            path = f"{self._root}/manifest.json"
            trials = sum(map(self.trials_of, self._missing))
            manifest = self._place.with_run(self._fs.cat_file(path), self._parts, trials, seconds, threads)
            _put(self._fs, path, manifest.encode())

    def close(self) -> None:
        pass


def _put(fs: Any, path: str, data: bytes) -> None:
    """Writes a file under a temporary name and moves it, so that it is never incomplete."""
    folder, name = path.rsplit("/", 1)
    temporary = f"{folder}/.{name}.{secrets.randbits(60)}-0.tmp"
    try:
        fs.pipe_file(temporary, data)
        fs.mv(temporary, path)
    except BaseException:
        if fs.exists(temporary):
            fs.rm_file(temporary)
        raise


_Place = SharedFolder | _RemoteDataset


def _place(study: Study, out: str | os.PathLike[str] | tuple[Any, str], part_size: int | None) -> tuple[_Place, Target]:
    if isinstance(out, tuple):
        fs, root = out
    else:
        root = os.fspath(out)
        fs, root = url_to_fs(root) if "://" in root else (None, root)
    if fs is None or isinstance(fs, LocalFileSystem):
        return SharedFolder(study, str(root), part_size), os.path.abspath(root)
    root = root.rstrip("/")
    if any(mark in root for mark in "*?["):
        raise SmaltiError(f"out is {root!r}; expected a path without *, ? and [, which file systems treat as patterns")
    return _RemoteDataset(study, fs, root, part_size), (fs, root)


_ready: dict[tuple[str, bool], PartMaker] = {}
_preparing = threading.Lock()


def _maker(manifest: str, scenes: bytes, cache: bool) -> PartMaker:
    """Prepares a study once per process, and keeps the last one."""
    with _preparing:
        maker = _ready.get((manifest, cache))
        if maker is None:
            _ready.clear()
            maker = _ready[manifest, cache] = PartMaker(manifest, scenes, cache)
        return maker


def _make(manifest: str, scenes: bytes, part: int, target: Target, cache: bool) -> tuple[int, int, float] | SmaltiError:
    """Computes and writes a part on a worker; returns its number, bytes and seconds. A permanent error is returned, not raised, since
    Dask would retry the task."""
    start = time.monotonic()
    try:
        maker = _maker(manifest, scenes, cache)
        if isinstance(target, str):
            size = maker.write(part, target)
        else:
            fs, root = target
            data = maker.encode(part)
            size = len(data)
            _put(fs, f"{root}/{maker.name(part)}", data)
    except SmaltiError as error:
        return error
    return part, size, time.monotonic() - start


def _ensure_usable(client: Any) -> None:
    if not isinstance(client, distributed.Client):
        raise SmaltiError(f"client is {type(client).__name__}; expected a dask.distributed.Client")
    if client.asynchronous:
        raise SmaltiError("the client is asynchronous; expected asynchronous=False")


def _threads(client: distributed.Client) -> int:
    return sum(client.nthreads().values())


def _compute(
    client: distributed.Client, study: Study, place: _Place, target: Target, cache: bool, done: Callable[[int], None]
) -> None:
    token = secrets.token_hex(8)
    # These are results of tasks, which Dask computes again when the worker that holds them dies.
    manifest = client.submit(str, place.manifest(), key=f"smalti-study-{token}", pure=False)
    scenes = client.submit(bytes, scenes_in_files(study), key=f"smalti-scenes-{token}", pure=False)
    waiting = iter(place.missing())

    def send(number: int) -> Iterator[distributed.Future[Any]]:
        for part in islice(waiting, max(number, 0)):
            key = f"smalti-part-{token}-{part}"
            yield client.submit(_make, manifest, scenes, part, target, cache, key=key, pure=False, retries=RETRIES)

    wanted, asked = AHEAD * max(_threads(client), 1), time.monotonic()
    sent = set(send(wanted))
    pending: Any = distributed.as_completed(sent)
    try:
        for future in pending:
            made = future.result()
            if isinstance(made, SmaltiError):
                raise made
            sent.discard(future)
            place.adopt(made[0])
            done(made[0])
            # A cluster may grow during the work. A query after every part would burden the scheduler.
            if time.monotonic() > asked + PATIENCE:
                wanted, asked = AHEAD * max(_threads(client), 1), time.monotonic()
            more = list(send(wanted - len(sent)))
            sent.update(more)
            pending.update(more)
    finally:
        if sent:
            client.cancel(list(sent))


def sweep(
    client: Any,
    study: Study,
    out: str | os.PathLike[str] | tuple[Any, str],
    part_size: int | None,
    cache: bool,
    open_progress: Open,
) -> str | None:
    """See `smalti.sweep`. Returns the folder, or None for another file system."""
    _ensure_usable(client)
    place, target = _place(study, out, part_size)
    try:
        missing = place.missing()
        total = sum(map(place.trials_of, missing))
        start, count = time.monotonic(), 0
        with open_progress() as report:

            def done(part: int) -> None:
                nonlocal count
                count += place.trials_of(part)
                if report is not None:
                    report(count, total)

            _compute(client, study, place, target, cache, done)
        place.finish(time.monotonic() - start, _threads(client))
    finally:
        place.close()
    return target if isinstance(target, str) else None


_searches: dict[str, DesignSearch] = {}


def _searched(source: str, light: list[bytes], task: str, part: str, known: list[str]) -> str | SmaltiError:
    """Searches a part of a design on a worker; returns its line. A permanent error is returned, not raised, since Dask would retry the task."""
    try:
        with _preparing:
            search = _searches.get(task)
            if search is None:
                search = DesignSearch(source, None, "all", None, light, None)
                if search.hash() != task:
                    return SmaltiError(
                        f"a worker reads another design from {source}, or has another version of Smalti than the client; expected the same"
                    )
                _searches.clear()
                _searches[task] = search
        return search.search(part, known)
    except SmaltiError as error:
        return error


def design(client: Any, source: str, search: DesignSearch, report: Callable[[int, int], object] | None) -> None:
    """Searches on the workers all parts of a design. See `smalti.design`."""
    _ensure_usable(client)
    token, task, done = secrets.token_hex(8), search.hash(), 0
    light = client.submit(list, search.light(), key=f"smalti-light-{token}", pure=False)
    # Later parts begin with what earlier ones found.
    while parts := search.open_parts():
        known = client.submit(list, search.known(), key=f"smalti-known-{token}-{done}", pure=False)
        sent = [
            client.submit(
                _searched, source, light, task, part, known, key=f"smalti-part-{token}-{done}-{i}", pure=False, retries=RETRIES
            )
            for i, part in enumerate(parts)
        ]
        try:
            for count, future in enumerate(distributed.as_completed(sent), start=1):
                line = future.result()
                if isinstance(line, SmaltiError):
                    raise line
                search.add(line)
                if report is not None:
                    report(done + count, done + len(parts))
        finally:
            client.cancel(sent)
        done += len(parts)
