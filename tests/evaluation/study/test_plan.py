"""Who is asked to do what."""

from __future__ import annotations

from pathlib import Path

import pytest

from halo_service.errors import UserError
from halo_service.evaluation.study import plan as matrix
from halo_service.evaluation.study.plan import REPORTED, TASKS, TUNED, Person, plan, quick_plan
from halo_service.virtual.materials import STUDIED
from halo_service.virtual.sim_url import parse_sim_url


def test_the_full_matrix_is_the_papers_twelve_users_on_five_materials() -> None:
    matrix = plan()
    touches = sum(task.touches or 0 for tasks in matrix.values() for task in tasks)
    assert (len(matrix), touches) == (60, 3840)


def test_each_user_does_once_what_is_done_once_and_the_materials_take_turns() -> None:
    for task in TASKS:
        persons = [person for person, tasks in plan().items() if task in tasks]
        if not task.every_material:
            assert [person.seed for person in persons] == list(REPORTED)
            assert {person.material for person in persons} == set(STUDIED)


def test_whom_anything_was_tuned_on_is_not_reported() -> None:
    assert not set(TUNED) & set(REPORTED)
    assert {person.seed for person in quick_plan()} <= set(TUNED)


def test_the_small_matrix_has_sixty_touches_on_three_materials() -> None:
    matrix = quick_plan()
    touches = sum(task.touches or 0 for tasks in matrix.values() for task in tasks)
    assert (touches, len({person.material for person in matrix})) == (60, 3)
    assert {"hover-5", "pressure-5"} <= {task.name for tasks in matrix.values() for task in tasks}


@pytest.mark.parametrize("task", matrix.KNOWN, ids=lambda task: task.name)
def test_the_virtual_kinect_understands_every_task(task: matrix.Task) -> None:
    request = parse_sim_url(Person(204, "foam").source(task))
    assert (request.scenario, request.room.seed, request.room.material) == (
        task.scenario,
        204,
        "foam",
    )


def test_no_two_tasks_share_a_file() -> None:
    assert len({task.name for task in matrix.KNOWN}) == len(matrix.KNOWN)


def test_label_files_take_turns_and_their_paths_may_hold_anything(tmp_path: Path) -> None:
    files = [tmp_path / "a & b.txt", tmp_path / "c.txt"]
    for file in files:
        file.write_text("1,touchdown,5,5,1000\n1,touchend,0,0,1100\n")
    given = plan(users=(301, 302, 303), labels=files)
    played = [
        parse_sim_url(person.source(task)).room.labels
        for person, tasks in given.items()
        for task in tasks
        if task.scenario == "labels"
    ]
    assert played == [str(files[0]), str(files[1]), str(files[0])]


def test_an_unknown_name_is_answered_with_the_known_ones() -> None:
    with pytest.raises(UserError, match="no material 'stone'; known: paper, wood"):
        matrix.chosen(["stone"], STUDIED, "material")
