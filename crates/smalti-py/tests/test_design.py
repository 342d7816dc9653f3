"""The search for the best colour filter array."""

from __future__ import annotations

from pathlib import Path

import pytest
import smalti

SMALL = """
camera = "bayer"
colors = [3]
luminances_cd_m2 = [10]
rivals = false
[filters.pigments]
[mosaics]
given = [["bc", "ab"]]
[search]
starts = 2
steps = 10
[light]
side = 3
max_components = 4
step_px = 8
"""


def scenes() -> list[smalti.Scene]:
    return [smalti.Scene("dead-leaves?rows=96&cols=128&largest=40&seed=%d" % seed) for seed in (1, 2)]


def test_a_design_is_a_camera(tmp_path: Path) -> None:
    file = tmp_path / "small.toml"
    file.write_text(SMALL)
    told: list[int] = []
    found = smalti.design(file, scenes=scenes(), resume=tmp_path / "log", progress=told.append)
    assert told == sorted(told) and told
    assert found["searched"][0]["cost"] < found["own"]["cost"]
    assert found.camera.name == "small" and found.rivals == {} and found.front == []
    assert found["light"][0]["scenes"] == 2
    # The same call finds everything in the log.
    again = smalti.design(file, scenes=scenes(), resume=tmp_path / "log", progress=False)
    assert again["searched"] == found["searched"]
    photo = found.camera.photograph(smalti.Scene("macbeth"), noise="none")
    assert photo.raw.shape[0] > 0


def test_designs_that_cannot_be_name_the_key(tmp_path: Path) -> None:
    assert "pigments-4" in smalti.designs()
    file = tmp_path / "wrong.toml"
    file.write_text(SMALL.replace("starts = 2", "starts = 0"))
    with pytest.raises(smalti.SmaltiError, match="search.starts"):
        smalti.design(file, progress=False)
    with pytest.raises(smalti.SmaltiError, match="did you mean 'pigments-"):
        smalti.design("pigments-9", progress=False)
