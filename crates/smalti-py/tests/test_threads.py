"""Long work leaves the interpreter to others, and ends on Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import smalti

LONG = """
import sys, smalti
print("at work", flush=True)
try:
    {work}
except KeyboardInterrupt:
    print("interrupted", flush=True)
    sys.exit(7)
"""


def test_another_thread_makes_progress() -> None:
    camera = smalti.Camera("bayer")
    scene = smalti.Scene("dead-leaves?rows=1500&cols=2000&seed=5")
    steps, stop = 0, threading.Event()

    def count() -> None:
        nonlocal steps
        while not stop.is_set():
            steps += 1
            time.sleep(0.001)

    other = threading.Thread(target=count)
    start = time.monotonic()
    other.start()
    camera.optical_image(scene)
    elapsed = time.monotonic() - start
    stop.set()
    other.join()
    assert elapsed > 0.1, "too short to tell"
    # A lock that is held would let it take one step at the start and one at the end.
    assert steps > 20 * elapsed


@pytest.mark.parametrize(
    "work",
    [
        "smalti.train(smalti.Camera('bayer'), progress=False)",
        "smalti.sweep('table2-l3', sys.argv[1], part_size=100000, progress=False)",
        "smalti.compare([smalti.Camera('bayer')], processing=['bilinear'], luminances_cd_m2=[float(i) for i in range(1, 200)], progress=False)",
        # Each far longer than the test would wait.
        "smalti.light_gain(smalti.Camera('rgbw'), smalti.Camera('bayer'), scenes=['dead-leaves', 'macbeth'] * 50, progress=False)",
        "smalti.sweep('table2', sys.argv[1], progress=False); smalti.report(sys.argv[1], trials=range(3000), progress=False)",
    ],
)
def test_ctrl_c_ends_it(work: str, tmp_path: Path) -> None:
    program = LONG.format(work=work)
    child = subprocess.Popen([sys.executable, "-c", program, str(tmp_path / "out")], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline() == "at work\n"
    time.sleep(2.0)
    assert child.poll() is None, "it ended before it could be interrupted"
    sent = time.monotonic()
    os.kill(child.pid, signal.SIGINT)
    out, _ = child.communicate(timeout=60)
    assert out == "interrupted\n" and child.returncode == 7
    # Between steps that are whole in themselves: a scene, some trials.
    assert time.monotonic() - sent < 30


def test_an_error_of_the_progress_ends_it(tmp_path: Path) -> None:
    def refuse(done: int) -> None:
        raise ZeroDivisionError(f"after {done}")

    with pytest.raises(ZeroDivisionError, match="after"):
        smalti.sweep("table2", tmp_path / "out", part_size=100_000, progress=refuse)


def test_many_threads_share_objects() -> None:
    camera, scene = smalti.Camera("bayer"), smalti.Scene("macbeth")
    raws: list[bytes] = []

    def take() -> None:
        raws.append(camera.photograph(scene).raw.samples.tobytes())

    threads = [threading.Thread(target=take) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(raws) == 4 and len(set(raws)) == 1
