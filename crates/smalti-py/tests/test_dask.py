"""A cluster writes what one machine writes, whatever becomes of its workers."""

from __future__ import annotations

import json
import os
import secrets
import signal
from collections.abc import Iterator
from pathlib import Path

import fsspec  # type: ignore[import-untyped]
import pytest
import smalti
from distributed import Client, LocalCluster
from smalti import _cluster, _smalti

import conftest
from conftest import parts, whole_parts

SIZE = 16
STUDY = conftest.STUDY.format(sets=20, mosaics=6)


def runs(folder: Path) -> list[dict[str, object]]:
    found: list[dict[str, object]] = json.loads((folder / "manifest.json").read_text())["runs"]
    return found


@pytest.fixture(scope="module")
def study() -> smalti.Study:
    return smalti.Study.from_toml(STUDY)


@pytest.fixture(scope="module")
def expected(study: smalti.Study, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("alone")
    smalti.sweep(study, folder, part_size=SIZE, progress=False)
    return parts(folder)


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    """Of two processes with a thread each."""
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster,
        Client(cluster) as client,
    ):
        yield client


def test_processes_write_the_same_bytes(
    client: Client, study: smalti.Study, expected: dict[str, bytes], tmp_path: Path
) -> None:
    told: list[int] = []
    results = smalti.sweep(study, tmp_path, client=client, part_size=SIZE, progress=told.append)
    assert results is not None and results.complete and len(results) == len(study) == 480
    results.verify()
    assert parts(tmp_path) == expected and len(expected) == 30
    assert told == sorted(told) and told[-1] == 480 and len(told) == 30
    (run,) = runs(tmp_path)
    timings = run["timings"]
    assert run["parts"] == 30 and run["shard"] is None and isinstance(timings, dict)
    assert timings["trials"] == 480 and timings["threads"] == 2 and timings["seconds"] > 0
    # Nothing is left to do, by either way.
    smalti.sweep(study, tmp_path, client=client, progress=False)
    smalti.sweep(study, tmp_path, progress=False)
    assert parts(tmp_path) == expected and runs(tmp_path) == [run]


def test_a_worker_that_is_killed_is_made_up_for(
    client: Client, study: smalti.Study, expected: dict[str, bytes], tmp_path: Path
) -> None:
    before = client.run(os.getpid)
    left: list[int] = []

    def kill_one(done: int) -> None:
        if not left:
            left.append(len(study) - done)
            os.kill(next(iter(before.values())), signal.SIGKILL)

    results = smalti.sweep(study, tmp_path, client=client, part_size=SIZE, progress=kill_one)
    assert left[0] > 0 and results is not None and results.complete
    # What it was writing may be left, under a temporary name.
    assert whole_parts(tmp_path) == expected
    client.wait_for_workers(2, timeout=60)
    assert set(client.run(os.getpid).values()) != set(before.values())


def test_what_was_interrupted_goes_on(
    client: Client, study: smalti.Study, expected: dict[str, bytes], tmp_path: Path
) -> None:
    def interrupt(done: int) -> None:
        if done >= 3 * SIZE:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        smalti.sweep(study, tmp_path, client=client, part_size=SIZE, progress=interrupt)
    # A worker finishes the part that it is at.
    whole = whole_parts(tmp_path)
    assert 3 <= len(whole) < 30 and whole.items() <= expected.items() and runs(tmp_path) == []
    # The lock is free, the size of parts that of the folder.
    results = smalti.sweep(study, tmp_path, client=client, progress=False)
    assert results is not None and results.complete
    (run,) = runs(tmp_path)
    assert isinstance(run["parts"], int) and run["parts"] <= 30 - len(whole)
    results.verify()
    assert whole_parts(tmp_path) == expected


def test_another_study_is_refused(client: Client, study: smalti.Study, tmp_path: Path) -> None:
    other = smalti.Study.from_toml(STUDY.replace("[sample]", "seed = 9\n[sample]", 1))
    smalti.sweep("aliasing", tmp_path / "one", progress=False)
    before = parts(tmp_path / "one")
    with pytest.raises(smalti.SmaltiError, match="another study or version:(.|\n)*seed"):
        smalti.sweep(other, tmp_path / "one", client=client, progress=False)
    assert parts(tmp_path / "one") == before


def test_a_second_run_at_once_is_refused(client: Client, study: smalti.Study, tmp_path: Path) -> None:
    said: list[str] = []

    def begin_another(done: int) -> None:
        with pytest.raises(smalti.SmaltiError, match="another run is using") as refused:
            smalti.sweep(study, tmp_path, client=client, part_size=SIZE * 8, progress=False)
        said.append(str(refused.value))

    smalti.sweep(study, tmp_path, client=client, part_size=SIZE * 10, progress=begin_another)
    assert len(said) == 3 and str(tmp_path) in said[0]


def test_any_file_system_holds_the_same_bytes(study: smalti.Study, expected: dict[str, bytes]) -> None:
    url = f"memory://{secrets.token_hex(4)}/out"
    fs, root = fsspec.core.url_to_fs(url)

    def stored() -> dict[str, bytes]:
        return {p.rsplit("/", 1)[-1]: fs.cat_file(p) for p in fs.ls(f"{root}/trials", detail=False)}

    # Threads, since such a memory is that of a process.
    with (
        LocalCluster(n_workers=1, threads_per_worker=2, processes=False, dashboard_address=":0") as cluster,
        Client(cluster) as client,
    ):

        def interrupt(done: int) -> None:
            if done >= 3 * SIZE:
                raise ZeroDivisionError

        with pytest.raises(ZeroDivisionError):
            smalti.sweep(study, url, client=client, part_size=SIZE, progress=interrupt)
        assert 3 <= len(stored()) < 30
        assert smalti.sweep(study, (fs, root), client=client, progress=False) is None
        assert stored() == expected
        manifest = json.loads(fs.cat_file(f"{root}/manifest.json"))
        assert len(manifest["runs"]) == 1 and 0 < manifest["runs"][0]["parts"] <= 27
        with pytest.raises(smalti.SmaltiError, match="another study"):
            smalti.sweep("aliasing", url, client=client, progress=False)
        fs.pipe_file(f"{root}/trials/mine.txt", b"")
        with pytest.raises(smalti.SmaltiError, match="mine.txt is not a part"):
            smalti.sweep(study, url, client=client, progress=False)
        fs.pipe_file(f"{root}/other/mine.txt", b"")
        with pytest.raises(smalti.SmaltiError, match="holds mine.txt but no manifest.json"):
            smalti.sweep(study, f"{url}/other", client=client, progress=False)


def test_errors_of_workers_arrive(client: Client, tmp_path: Path) -> None:
    study = smalti.Study.from_toml(STUDY.replace("[20, 75]", "[1e300]"))
    with pytest.raises(smalti.SmaltiError) as alone:
        smalti.sweep(study, tmp_path / "alone", progress=False)
    with pytest.raises(smalti.SmaltiError) as there:
        smalti.sweep(study, tmp_path / "cluster", client=client, progress=False)
    assert str(there.value) == str(alone.value)
    # It had been begun.
    assert runs(tmp_path / "cluster") == [] and parts(tmp_path / "cluster") == {}


def test_scenes_in_files_are_sent(client: Client, tmp_path: Path) -> None:
    """The file is gone when workers begin."""
    smalti.Scene("macbeth?patch=8").write(tmp_path / "chart.exr")
    smalti.Scene("dead-leaves?rows=40&cols=60&least=3&largest=20&seed=2").write(tmp_path / "leaves.npz")
    text = conftest.STUDY.format(sets=2, mosaics=2)
    text = text.replace('name = "small"', 'name = "small"\nscenes = ["chart.exr", "zone-plate?size=32", "leaves.npz"]')
    study = smalti.Study.from_toml(text, tmp_path)
    (tmp_path / "chart.exr").unlink()
    (tmp_path / "leaves.npz").unlink()
    smalti.sweep(study, tmp_path / "alone", part_size=8, progress=False)
    smalti.sweep(study, tmp_path / "cluster", client=client, part_size=8, progress=False)
    assert parts(tmp_path / "cluster") == parts(tmp_path / "alone") != {}


def test_what_cannot_be_is_refused(client: Client, study: smalti.Study, tmp_path: Path) -> None:
    with pytest.raises(smalti.SmaltiError, match="shard and client"):
        smalti.sweep(study, tmp_path / "out", client=client, shard="1/2")  # type: ignore[call-overload]
    with pytest.raises(smalti.SmaltiError, match=r"expected a dask\.distributed\.Client"):
        smalti.sweep(study, tmp_path / "out", client="tcp://here", progress=False)
    with pytest.raises(smalti.SmaltiError, match="patterns"):
        smalti.sweep(study, "memory://a*b", client=client, progress=False)
    (tmp_path / "file").write_text("")
    with pytest.raises(smalti.SmaltiError, match="is a file; expected a folder"):
        smalti.sweep(study, tmp_path / "file", client=client, progress=False)
    assert not (tmp_path / "out").exists()


DESIGN = """
camera = "bayer"
colors = [3]
luminances_cd_m2 = [1, 10]
rivals = false
[filters.pigments]
[mosaics.tile]
rows = 2
cols = 3
[search]
starts = 2
steps = 4
[front]
points = 3
[[front.aims]]
name = "dark"
cpsnr_db = 1
luminances_cd_m2 = [1]
[[front.aims]]
name = "bright"
cpsnr_db = 1
luminances_cd_m2 = [10]
[light]
side = 3
max_components = 4
step_px = 8
"""


def test_workers_search_what_one_process_finds(client: Client, tmp_path: Path) -> None:
    file = tmp_path / "small.toml"
    file.write_text(DESIGN)
    scenes = [smalti.Scene("dead-leaves?rows=96&cols=128&largest=40")]
    alone = smalti.design(file, scenes=scenes, progress=False)
    told: list[int] = []
    shared = smalti.design(file, scenes=scenes, resume=tmp_path / "log", client=client, progress=told.append)
    assert shared["searched"] == alone["searched"] and shared["front"] == alone["front"]
    # More mosaics than are searched in full: first short searches of all, then full ones, then the front.
    assert len(shared["searched"]) > 6 and told == sorted(told) and told[-1] > len(shared["searched"]) + 6
    # The log has every part: after the statistics of the light, nothing is left to search.
    told.clear()
    smalti.design(file, scenes=scenes, resume=tmp_path / "log", client=client, progress=told.append)
    assert told == [1]


def test_workers_that_read_another_design_are_refused(client: Client, tmp_path: Path) -> None:
    file = tmp_path / "small.toml"
    file.write_text(DESIGN.replace("steps = 4", "steps = 6"))
    scenes = [smalti.Scene("dead-leaves?rows=96&cols=128&largest=40")]

    search = _smalti.DesignSearch(file, scenes, "all", None, None, None)
    file.write_text(DESIGN)
    with pytest.raises(smalti.SmaltiError, match=r"another design from .*small\.toml"):
        _cluster.design(client, str(file), search, None)
    with pytest.raises(smalti.SmaltiError, match="client is str; expected a dask"):
        smalti.design(file, scenes=scenes, client="tcp://scheduler", progress=False)
