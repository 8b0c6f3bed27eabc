"""Which user does which task."""

from __future__ import annotations

from pathlib import Path

import pytest

from halo_service.errors import UserError
from halo_service.evaluation.study import plan as study
from halo_service.evaluation.study.plan import REPORTED, TASKS, TUNED, User, plan, quick_plan
from halo_service.virtual.materials import STUDIED
from halo_service.virtual.sensor_model import SENSORS
from halo_service.virtual.sim_url import parse_sim_url


def test_the_full_study_is_the_papers_twelve_users_on_five_materials() -> None:
    users = plan()
    touches = sum(task.touches or 0 for tasks in users.values() for task in tasks)
    assert (len(users), touches) == (60, 3840)


def test_each_user_does_most_tasks_once_and_the_materials_alternate() -> None:
    for task in TASKS:
        users = [user for user, tasks in plan().items() if task in tasks]
        if not task.every_material:
            assert [user.seed for user in users] == list(REPORTED)
            assert {user.material for user in users} == set(STUDIED)


@pytest.mark.parametrize("sensor", ["kind", "true"])
def test_the_quick_study_runs_on_either_sensor(sensor: str) -> None:
    for user, tasks in quick_plan(sensor=sensor).items():
        sensors = {parse_sim_url(user.source(task)).room.sensor for task in tasks}
        assert sensors == {SENSORS[sensor]}


def test_tuning_users_are_not_reported() -> None:
    assert not set(TUNED) & set(REPORTED)
    assert {user.seed for user in quick_plan()} <= set(TUNED)


def test_the_small_study_has_sixty_touches_on_three_materials() -> None:
    users = quick_plan()
    touches = sum(task.touches or 0 for tasks in users.values() for task in tasks)
    assert (touches, len({user.material for user in users})) == (60, 3)
    assert {"hover-5", "pressure-5"} <= {task.name for tasks in users.values() for task in tasks}


@pytest.mark.parametrize("task", study.ALL_TASKS, ids=lambda task: task.name)
def test_the_virtual_camera_knows_every_task(task: study.Task) -> None:
    request = parse_sim_url(User(204, "foam").source(task))
    assert (request.scenario, request.room.seed, request.room.material) == (
        task.scenario,
        204,
        "foam",
    )


FRESH = (*range(213, 219), *range(313, 325))


@pytest.mark.parametrize("seed", FRESH)
def test_a_fresh_user_has_one_camera_in_all_tasks(seed: int) -> None:
    rooms = [parse_sim_url(User(seed, "wood").source(task)).room for task in study.ALL_TASKS]
    cameras = {
        (r.camera_height_mm, r.camera_pitch_deg, r.camera_yaw_deg, r.mode, r.device, r.curve)
        for r in rooms
    }
    assert len(cameras) == 1


@pytest.mark.parametrize("seeds", [FRESH[:6], FRESH[6:]])
def test_fresh_users_mix_heights_tilts_modes_and_devices(seeds: tuple[int, ...]) -> None:
    assert set(seeds) <= set(TUNED if seeds[0] < 300 else REPORTED)
    cameras = [study.GEOMETRY[seed] for seed in seeds]
    heights = [camera.height_mm for camera in cameras]
    assert (min(heights), max(heights)) == (350.0, 1000.0)
    assert max(abs(camera.pitch_deg) for camera in cameras) == 20.0
    assert {camera.mode for camera in cameras} == {study.NARROW, study.BINNED, study.WIDE}
    assert {camera.device for camera in cameras} == {"kinect", "bolt"}


VIEWED = User(213, "plastic", "kind", 700.0, study.WIDE)


@pytest.mark.parametrize(
    "user",
    [
        User(205, "paper"),
        User(205, "paper", "kind"),
        User(205, "paper", height_mm=350.0),
        User(205, "paper", mode=study.BINNED),
        User(205, "paper", height_mm=487.5, mode=study.NARROW),
        VIEWED,
    ],
    ids=lambda user: user.name,
)
def test_a_folders_name_says_which_user_it_is(user: User) -> None:
    assert study.user_of(user.name) == user


@pytest.mark.parametrize(
    "name", ["", "notes", "205", "205-paper-700", "205-paper-1.2.3mm", "205-paper-kind-x"]
)
def test_other_folders_are_no_users(name: str) -> None:
    assert study.user_of(name) is None


def test_a_sweep_sees_each_user_from_each_height_in_each_mode() -> None:
    swept = study.seen_from(quick_plan((204,)), (350.0, 1000.0), (study.NARROW, study.WIDE))
    rooms = [parse_sim_url(user.source(tasks[0])).room for user, tasks in swept.items()]
    assert [(room.camera_height_mm, room.mode) for room in rooms] == [
        (350.0, study.NARROW),
        (350.0, study.WIDE),
        (1000.0, study.NARROW),
        (1000.0, study.WIDE),
    ]
    own = quick_plan((204,))
    assert study.seen_from(own, (), ()) == own


def test_a_sweep_moves_also_users_with_a_camera_of_their_own() -> None:
    room = parse_sim_url(VIEWED.source(study.POINTING)).room
    assert (room.camera_height_mm, room.mode) == (700.0, study.WIDE)
    assert room.camera_pitch_deg == study.GEOMETRY[213].pitch_deg


def test_no_two_tasks_share_a_file() -> None:
    assert len({task.name for task in study.ALL_TASKS}) == len(study.ALL_TASKS)


def test_label_files_alternate_and_their_paths_may_contain_any_character(tmp_path: Path) -> None:
    files = [tmp_path / "a & b.txt", tmp_path / "c.txt"]
    for file in files:
        file.write_text("1,touchdown,5,5,1000\n1,touchend,0,0,1100\n")
    given = plan(users=(301, 302, 303), labels=files)
    files_used = [
        parse_sim_url(user.source(task)).room.labels
        for user, tasks in given.items()
        for task in tasks
        if task.scenario == "labels"
    ]
    assert files_used == [str(files[0]), str(files[1]), str(files[0])]


def test_an_unknown_name_lists_the_valid_ones() -> None:
    with pytest.raises(UserError, match="unknown material 'stone'; choose from: paper, wood"):
        study.choose(["stone"], STUDIED, "material")
