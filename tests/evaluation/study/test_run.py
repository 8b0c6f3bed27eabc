"""The pool of processes: what it returns, and that it ends."""

from __future__ import annotations

import io
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from halo_service.errors import UserError
from halo_service.evaluation.methods import METHODS
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.report.csv_file import write
from halo_service.evaluation.study.cache import RecordingCache
from halo_service.evaluation.study.plan import LABELS, Task
from halo_service.evaluation.study.run import StudyRequest, run, work_s
from halo_service.sensing import SensingSettings
from tests.evaluation.study.empty_table import SHORT, USER

HALO = Path(sys.executable).with_name("halo")
SOON_S = 300.0
"""A busy machine is slow; no figure depends on this."""


def request_for(cache: RecordingCache, methods: Sequence[str], *tasks: Task) -> StudyRequest:
    return StudyRequest({USER: tasks}, tuple(methods), cache, SensingSettings(), 1)


def test_a_user_who_cannot_be_calibrated_is_a_result_with_the_reason(cache: RecordingCache) -> None:
    methods = ("ours", "paper")
    request = request_for(cache, methods, SHORT)
    done: list[float] = []
    results = run(request, done.append)
    assert [each.method for each in results] == list(methods)
    for each in results:
        assert each.scores is None
        assert "frames came during 'hover'" in each.refused
    assert sum(done) == pytest.approx(work_s(request))
    assert not cache.has(USER, SHORT)  # nothing is simulated without a method
    out = io.StringIO()
    write(results, "1.2.3", out)
    head, *rows = out.getvalue().splitlines()
    assert head.startswith("seed,subject,material,family,task,method,figure,value,note")
    assert len(rows) == len(methods)
    assert all(row.startswith("205,205-paper,paper,") and "'hover'" in row for row in rows)


@pytest.fixture(scope="module")
def cached_run(cache: RecordingCache) -> tuple[Result, ...]:
    """All methods on two cached recordings; the label file of the second is gone."""
    shown, labelled = replace(SHORT, name="shown"), replace(LABELS, name="labels-gone")
    cache.ensure(USER, shown)
    shutil.copy(cache.path(USER, shown), cache.path(USER, labelled))
    return run(
        request_for(replace(cache, simulates=False), tuple(METHODS), shown, labelled),
        lambda _: None,
    )


def test_where_ours_is_refused_the_rivals_that_need_no_states_still_run(
    cached_run: tuple[Result, ...],
) -> None:
    results = [each for each in cached_run if each.task == "shown"]
    assert {each.method: each.scores is None for each in results} == {
        "ours": True,
        "paper": True,
        "direct": False,
        "wilson": False,
    }
    assert {bool(each.refused) for each in results if each.scores is not None} == {False}


def test_a_cached_recording_of_labels_is_scored_without_its_label_file(
    cached_run: tuple[Result, ...],
) -> None:
    (result,) = (r for r in cached_run if (r.task, r.method) == ("labels-gone", "wilson"))
    assert result.refused == ""
    assert result.scores is not None


def test_a_folder_that_another_run_uses_is_refused(
    cache: RecordingCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("halo_service.files.LOCK_WAIT_S", 0.05)
    with cache.exclusive(), pytest.raises(UserError, match=r"another run is writing to .*: wait"):
        run(request_for(cache, ["ours"], SHORT), lambda _: None)


@pytest.fixture
def quick(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A run that has just begun to simulate; it ends with the test."""
    process = subprocess.Popen(
        [HALO, "evaluate", "--quick", "--jobs", "1", "--method", "ours", "--cache", tmp_path],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    yield process
    process.kill()
    process.communicate()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 130), (signal.SIGKILL, -9)]
)
def test_a_run_that_is_ended_leaves_no_process_and_no_half_written_file(
    quick: subprocess.Popen[str], tmp_path: Path, number: signal.Signals, code: int
) -> None:
    workers = _until(lambda: _working(quick.pid))
    quick.send_signal(number)
    out, err = quick.communicate(timeout=SOON_S)
    assert quick.returncode == code
    assert _until(lambda: not any(_alive(pid) for pid in workers))
    assert out == ""
    assert "Traceback" not in err
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == [".lock"]


def _until(condition):
    end = time.monotonic() + SOON_S
    while time.monotonic() < end:
        if answer := condition():
            return answer
        time.sleep(0.05)
    raise AssertionError("the condition stayed false")


def _working(parent: int) -> list[int]:
    """Return the workers once one of them watches its parent: in a second thread."""
    children = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
    busy = [int(pid) for pid in children if len(list(Path(f"/proc/{pid}/task").iterdir())) > 1]
    return [int(pid) for pid in children] if busy else []


def _alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{pid}/stat").read_text().split()[2] != "Z"
