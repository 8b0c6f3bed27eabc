"""What one writes after `sim`, and the sentence for each mistake."""

import dataclasses
import subprocess

import pytest

from halo_service.errors import UserError
from halo_service.values import Side
from halo_service.virtual.room import draw_room
from halo_service.virtual.scenarios import SCENARIOS
from halo_service.virtual.sim_url import OPTIONS, parse_sim_url


def test_everything_can_be_set_in_the_name():
    request = parse_sim_url(
        "sim:drumming?seed=3&material=foam&camera_height_mm=600&hand=left&family=sigmoid"
    )
    assert request.scenario == "drumming"
    room = request.room
    assert (room.seed, room.material, room.camera_height_mm) == (3, "foam", 600.0)
    assert (room.dominant, room.curve.family) == (Side.LEFT, "sigmoid")


SPELLINGS = [
    ("sim:demo,seed=3,material=foam", "sim:demo?seed=3&material=foam"),
    ("sim,seed=3", "sim?seed=3"),
    ("sim:,seed=3", "sim:?seed=3"),
    ("drumming,hand=left,drop=0", "drumming?hand=left&drop=0"),
    ("sim:demo,props=board,cup,seed=4", "sim:demo?props=board,cup&seed=4"),
    ("sim:demo,rings=index,little", "sim:demo?rings=index,little"),
    ("sim:demo", "sim:demo?"),
]


@pytest.mark.parametrize(("plain", "quoted"), SPELLINGS)
def test_the_spelling_that_no_shell_changes_means_the_same(plain, quoted):
    assert parse_sim_url(plain) == parse_sim_url(quoted)


@pytest.mark.parametrize(("plain", "quoted"), SPELLINGS)
def test_no_shell_changes_it(plain, quoted, tmp_path):
    del quoted
    said = subprocess.run(
        ["sh", "-c", f"echo {plain}"], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert said.stdout.strip() == plain
    assert not set(plain) & set("?*[]&;|<>(){}$`'\"\\!#~ ")


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("sim:demo,seed", "seed is ''"),
        ("sim:demo,seed=3,colour=red", "no option 'colour'"),
        ("sim:demo,material=glue", "no material 'glue'"),
        ("sim:juggling,seed=3", "no scenario 'juggling'"),
    ],
)
def test_a_mistake_in_the_plain_spelling_is_one_sentence(name, says):
    with pytest.raises(UserError, match=says):
        parse_sim_url(name)


@pytest.mark.parametrize("option, value", [("hand_size", 1.2), ("skin", 0.4), ("sleeve_mm", 40.0)])
def test_one_drawn_field_can_be_overridden_alone(option, value):
    user = parse_sim_url(f"sim:demo?seed=3&{option}={value}").room.user
    drawn = draw_room(3).user
    field = OPTIONS[option][0].removeprefix("user.")
    assert user == dataclasses.replace(drawn, **{field: value})


@pytest.mark.parametrize(
    "name", ["", "sim", "sim:", "sim:demo", "demo", "sim?seed=1", "sim:?seed=1"]
)
def test_the_default_is_the_demo_of_seed_1(name):
    request = parse_sim_url(name)
    assert (request.scenario, request.room) == ("demo", draw_room(1))


@pytest.mark.parametrize("scenario", [s for s in SCENARIOS if s != "labels"])
def test_every_scenario_has_a_name(scenario):
    assert parse_sim_url(f"sim:{scenario}").scenario == scenario


def test_the_seed_of_the_command_line_wins():
    assert parse_sim_url("sim:demo?seed=3", seed=8).room == draw_room(8)


MISTAKES = [
    ("sim:juggling", "no scenario 'juggling'; choose from: demo, idle"),
    ("sim:demo?material=glue", "no material 'glue'; choose from: paper, wood"),
    ("sim:demo?colour=red", "no option 'colour'; choose from: seed, material"),
    ("sim:demo?camera_hight_mm=500", "did you mean 'camera_height_mm'?"),
    ("sim:druming", "no scenario 'druming'; did you mean 'drumming'?"),
    ("sim:demo?camera_height_mm=-500", "camera_height_mm is -500; give 300 to 1500"),
    ("sim:demo?camera_height_mm=nan", "camera_height_mm is nan"),
    ("sim:demo?camera_height_mm=tall", "camera_height_mm is 'tall'; it must be a number"),
    ("sim:demo?camera_pitch_deg=90", "camera_pitch_deg is 90"),
    ("sim:demo?seed=-1", "seed is -1"),
    ("sim:demo?seed=x", "seed is 'x'; it must be a whole number"),
    ("sim:demo?hand=third", "hand is 'third'; it must be left or right"),
    (
        "sim:demo?family=cubic",
        "no halo family 'cubic'; choose from: straight, exponential, sigmoid",
    ),
    ("sim:demo?props=sofa", "no object 'sofa'; choose from: sheet, board, cup"),
    ("sim:demo?drop=1", "drop is 1; give 0 to 0.9"),
    ("sim:demo?noise=-2", "noise is -2"),
    ("sim:demo?hand_size=-1", "size is -1; give 0.7 to 1.3"),
    ("sim:demo?onset_mm=0", "onset_mm is 0"),
    ("sim:demo?projected=/nowhere.png", "finds no picture '/nowhere.png'"),
    ("sim:demo?sensor=ideal", "unknown virtual sensor 'ideal'; choose from: true, kind"),
    ("sim:demo?skin_offset_mm=40", "skin_offset_mm is 40; give 0 to 30"),
    ("sim:labels", "needs a file: sim:labels,labels=FILE"),
    ("sim:labels?labels=/nowhere.txt", "cannot be read"),
]


@pytest.mark.parametrize("name, sentence", MISTAKES, ids=[m[0] for m in MISTAKES])
def test_each_invalid_name_is_rejected_with_the_remedy(name, sentence):
    with pytest.raises(UserError) as caught:
        parse_sim_url(name)
    assert sentence in str(caught.value)
    assert str(caught.value).endswith((".", "?"))
