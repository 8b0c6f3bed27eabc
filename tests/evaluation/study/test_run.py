"""The pool: what it returns, and that it ends."""

from __future__ import annotations

import io
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from halo_service.errors import UserError
from halo_service.evaluation.methods import METHODS
from halo_service.evaluation.report.csv_rows import write
from halo_service.evaluation.study.cache import Studio
from halo_service.evaluation.study.plan import LABELS
from halo_service.evaluation.study.run import Order, run, work_s
from halo_service.sensing import SensingSettings
from tests.evaluation.study.empty_table import PERSON, SHORT, studio_in

HALO = Path(sys.executable).with_name("halo")
SOON_S = 300.0
"""A machine at the end of its tether takes its time; nothing is judged by it."""


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory) -> Studio:
    return studio_in(tmp_path_factory.mktemp("takes"))


def test_who_cannot_be_calibrated_is_a_result_with_the_sentence(studio: Studio) -> None:
    methods = ("ours", "paper")
    order = Order({PERSON: (SHORT,)}, methods, studio, SensingSettings(), 1)
    done: list[float] = []
    results = run(order, done.append)
    assert [each.method for each in results] == list(methods)
    for each in results:
        assert each.scores is None
        assert "frames came during 'hover'" in each.refused
    assert sum(done) == pytest.approx(work_s(order))
    assert not studio.has(PERSON, SHORT)  # nothing is drawn for nobody
    out = io.StringIO()
    write(results, "1.2.3", out)
    head, *rows = out.getvalue().splitlines()
    assert head.startswith("seed,subject,material,family,task,method,figure,value,note")
    assert len(rows) == len(methods)
    assert all(row.startswith("205,205-paper,paper,") and "'hover'" in row for row in rows)


def test_where_ours_is_refused_the_rivals_that_need_no_states_still_play(studio: Studio) -> None:
    shown = replace(SHORT, name="shown")
    order = Order({PERSON: (shown,)}, tuple(METHODS), studio, SensingSettings(), 1)
    results = run(order, lambda _: None)
    assert {each.method: each.scores is None for each in results} == {
        "ours": True,
        "paper": True,
        "direct": False,
        "wilson": False,
    }
    assert {bool(each.refused) for each in results if each.scores is not None} == {False}


def test_a_kept_take_of_labels_is_judged_without_its_label_file(studio: Studio) -> None:
    shown = replace(SHORT, name="shown")
    studio.provide(PERSON, shown)
    labelled = replace(LABELS, name="labels-gone")
    shutil.copy(studio.path(PERSON, shown), studio.path(PERSON, labelled))
    kept_only = replace(studio, draws=False)
    order = Order({PERSON: (labelled,)}, ("wilson",), kept_only, SensingSettings(), 1)
    (result,) = run(order, lambda _: None)
    assert (result.task, result.refused) == ("labels-gone", "")
    assert result.scores is not None


def test_a_folder_that_another_run_is_filling_is_told_as_that(
    studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("halo_service.files.LOCK_WAIT_S", 0.05)
    order = Order({PERSON: (SHORT,)}, ("ours",), studio, SensingSettings(), 1)
    with studio.to_itself(), pytest.raises(UserError, match=r"another run is filling .*: wait"):
        run(order, lambda _: None)


@pytest.fixture
def quick(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A run that has just begun to draw; it has ended when the test has, whatever that found."""
    process = subprocess.Popen(
        [HALO, "evaluate", "--quick", "--jobs", "1", "--method", "ours", "--keep", tmp_path],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    yield process
    process.kill()
    process.communicate()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes where Linux tells them")
@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 130), (signal.SIGKILL, -9)]
)
def test_whatever_ends_a_run_its_processes_end_and_nothing_half_written_stays(
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


def _until(says):
    end = time.monotonic() + SOON_S
    while time.monotonic() < end:
        if answer := says():
            return answer
        time.sleep(0.05)
    raise AssertionError("it did not happen")


def _working(parent: int) -> list[int]:
    """Return the workers once one of them has its watch over the parent: a second thread."""
    children = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
    busy = [int(pid) for pid in children if len(list(Path(f"/proc/{pid}/task").iterdir())) > 1]
    return [int(pid) for pid in children] if busy else []


def _alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{pid}/stat").read_text().split()[2] != "Z"
