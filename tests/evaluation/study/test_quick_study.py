"""The small study, as `.ci/run` asks for it: counts and ratios, never times."""

from __future__ import annotations

import csv
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from halo_service.evaluation.methods import METHODS
from halo_service.evaluation.study.plan import QUICK_USERS

pytestmark = pytest.mark.long

HALO = Path(sys.executable).with_name("halo")
RIVALS = tuple(name for name in METHODS if name != "ours")
LEVELS = ("hover_error_mm", "pressure_error_percent")
WITHOUT_FORCE = ("direct", "wilson")
"""They publish no force."""
COMPARED = tuple(
    (rival, figure)
    for rival in RIVALS
    for figure in LEVELS
    if not (rival in WITHOUT_FORCE and figure.startswith("pressure"))
)


class Study:
    """What `halo evaluate --quick` wrote."""

    def __init__(self, file: Path) -> None:
        with file.open(encoding="utf-8", newline="") as text:
            self._rows = list(csv.DictReader(text))

    def of(self, method: str, figure: str, task: str) -> list[float]:
        """Return a figure of each user who did a task."""
        return [float(row["value"]) for row in self._mine(method, figure, task)]

    def count(self, method: str, figure: str) -> int:
        """Return a count over all users' pointing."""
        values = self.of(method, figure, "pointing-20")
        assert len(values) == len(QUICK_USERS), f"{method} has no {figure} of all users"
        return int(sum(values))

    def f1(self, method: str) -> float:
        """Return F1 over all users' pointing."""
        hits = self.count(method, "touches") - self.count(method, "missed")
        wrong = sum(self.count(method, name) for name in ("doubled", "outside", "ghosts", "missed"))
        return 2.0 * hits / (2.0 * hits + wrong)

    def mean(self, method: str, figure: str, task: str) -> float:
        """Return a figure's mean over the users; without any there is none to compare."""
        values = self.of(method, figure, task)
        assert values, f"{method} has no {figure}"
        return sum(values) / len(values)

    def _mine(self, method: str, figure: str, task: str) -> Iterator[dict[str, str]]:
        for row in self._rows:
            if (row["method"], row["figure"], row["task"]) == (method, figure, task):
                yield row


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    folder = tmp_path_factory.mktemp("study")
    file = folder / "figures.csv"
    done = subprocess.run(
        [HALO, "evaluate", "--quick", "--cache", folder / "recordings", "--csv", file],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    print(done.stdout)
    return Study(file)


def test_all_users_are_calibrated_for_every_method(study: Study) -> None:
    assert {name: study.of(name, "calibrated", "pointing-20") for name in METHODS} == {
        name: [1.0, 1.0, 1.0] for name in METHODS
    }


def test_no_touch_of_sixty_is_missed_doubled_outside_or_a_ghost(study: Study) -> None:
    figures = ("touches", "missed", "doubled", "outside", "ghosts", "stuck")
    assert [study.count("ours", name) for name in figures] == [60, 0, 0, 0, 0, 0]


@pytest.mark.parametrize("rival", RIVALS)
def test_ours_finds_touches_at_least_as_well(study: Study, rival: str) -> None:
    assert study.f1("ours") >= study.f1(rival)


@pytest.mark.parametrize("rival, figure", COMPARED)
def test_ours_measures_levels_at_least_as_well(study: Study, rival: str, figure: str) -> None:
    """A rival without a figure has no reading at all."""
    kind = figure.partition("_")[0]
    ours = study.mean("ours", figure, f"{kind}-5")
    if study.of(rival, figure, f"{kind}-5"):
        assert ours <= study.mean(rival, figure, f"{kind}-5")
    else:
        assert study.of(rival, f"{kind}_no_reading_share", f"{kind}-5") == [1.0]


@pytest.mark.parametrize("rival", WITHOUT_FORCE)
def test_a_rival_without_a_force_has_no_pressure_error(study: Study, rival: str) -> None:
    assert study.of(rival, "pressure_no_reading_share", "pressure-5") == [1.0]
    assert study.of(rival, "pressure_error_percent", "pressure-5") == []


@pytest.mark.parametrize("rival", RIVALS)
def test_ours_measures_places_at_least_as_well(study: Study, rival: str) -> None:
    ours, theirs = (study.mean(name, "spatial_mean_mm", "pointing-20") for name in ("ours", rival))
    assert ours <= theirs
