"""Several virtual cameras over one table: one truth, a view each, and light that disturbs."""

import dataclasses
import itertools
import time

import numpy as np
import pytest
from scipy.spatial import cKDTree

from halo_service.canvas import layout
from halo_service.errors import UserError
from halo_service.values import Finger
from halo_service.virtual.clock import clocks_of
from halo_service.virtual.installation.interference import common_light, shares
from halo_service.virtual.installation.places import AREA_MM, canvas_mm
from halo_service.virtual.installation.truth import canvas_truth, layout_text
from halo_service.virtual.live import VirtualKinect
from halo_service.virtual.offline import SimulatedRecording
from halo_service.virtual.room import draw_room
from halo_service.virtual.scenarios import start_scenario
from halo_service.virtual.scenarios.crossing import ROUND_S, ROUNDS
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import parse_sim_url

FOUR = "sim:crossing,cameras=4,camera={},seed=3"


def cameras(name, count):
    return [parse_sim_url(name.format(number)) for number in range(1, count + 1)]


def on_canvas(room, points):
    """(N, 3) from a camera's surface."""
    homogeneous = np.column_stack([points, np.ones(len(points))])
    return (room.place.canvas_from_surface @ homogeneous.T).T[:, :3]


def test_all_cameras_see_one_hand_at_one_place():
    requests = cameras(FOUR, 4)
    scenarios = [start_scenario(each.scenario, each.room) for each in requests]
    seen = 0
    for t_s in np.arange(1.0, 9.0, 0.1):
        hands = [scenario.at(t_s).hands for scenario in scenarios]
        for same in zip(*hands, strict=True):
            pads = [
                on_canvas(request.room, hand.pad(Finger.INDEX)[None])[0]
                for request, hand in zip(requests, same, strict=True)
            ]
            assert np.ptp(pads, axis=0).max() < 1e-6
            seen += 1
    assert seen > 50


def test_the_truth_of_the_canvas_is_that_of_each_camera():
    request = parse_sim_url(FOUR.format(4))
    truth = list(canvas_truth(request, 9.0))
    by_time = {each["time_us"]: each["fingers"] for each in truth if "fingers" in each}
    scenario = start_scenario(request.scenario, request.room)
    compared = 0
    for time_us, fingers in itertools.islice(by_time.items(), 60, None, 5):
        index = [each for each in fingers if each["finger"] == "index"]
        for finger, hand in zip(index, scenario.at(time_us / 1e6).hands, strict=False):
            x, y, z = on_canvas(request.room, hand.pad(Finger.INDEX)[None])[0]
            assert (finger["x_mm"], finger["y_mm"]) == pytest.approx((x, y), abs=2e-3)
            assert finger["height_mm"] == pytest.approx(max(0.0, -z), abs=2e-3)
            compared += 1
    assert compared > 40
    mine = scenario.ended_contacts(9.0)
    touches = [each["contact"] for each in truth if "contact" in each]
    assert len(touches) == len(mine) > 2
    for touch, contact in zip(touches, mine, strict=True):
        place = on_canvas(request.room, np.array([[contact.x_mm, contact.y_mm, 0.0]]))[0]
        assert (touch["x_mm"], touch["y_mm"]) == pytest.approx(place[:2], abs=2e-3)


def cloud(request, hand, near_mm):
    """What a camera without noise measures within 10 mm of a fingertip, on the canvas, mm."""
    sensor = Sensor(request.room, colour_times=0)
    depth = sensor.frame(0, [hand]).depth
    rows, columns = np.nonzero(depth)
    px = np.column_stack([columns, rows]).astype(np.float64)
    points = sensor.camera.depth.rays(px) * depth[rows, columns, None]
    points = on_canvas(request.room, sensor.surface.from_camera(points))
    near = np.hypot(*(points[:, :2] - near_mm[:2]).T) < 10.0
    return points[near & (points[:, 2] < -6.0)]


def test_two_cameras_measure_the_same_fingertip():
    name = "sim:crossing,cameras=2,camera={},seed=3,sensor=kind,noise=0,skin_offset_mm=0"
    requests = cameras(name, 2)
    scenarios = [start_scenario(each.scenario, each.room) for each in requests]
    for t_s in np.arange(2.0, 9.0, 0.02):  # until a finger hovers over the overlap
        hands = [scenario.at(t_s).hands[0] for scenario in scenarios]
        tip = on_canvas(requests[0].room, hands[0].pad(Finger.INDEX)[None])[0]
        if 255.0 < tip[0] < 285.0 and tip[2] < -8.0:
            break
    skin = on_canvas(requests[0].room, hands[0].vertices)  # camera 1 gives the canvas its frame
    offsets = [
        off_mm(cloud(*each, tip), skin, hands[0].normals)
        for each in zip(requests, hands, strict=True)
    ]
    assert np.abs(offsets[0] - offsets[1]).max() < 1.0


def off_mm(cloud, skin, normals):
    """(3,) how far measured points have to move to lie on the skin."""
    moved = np.zeros(3)
    for _ in range(10):
        _, nearest = cKDTree(skin).query(cloud + moved)
        facing = normals[nearest]
        apart = np.einsum("ni,ni->n", skin[nearest] - cloud, facing)
        moved = np.linalg.lstsq(facing, apart, rcond=None)[0]
    return moved


def test_a_camera_that_joins_late_sees_the_same_as_one_that_was_there():
    request = parse_sim_url("sim:crossing,cameras=2,seed=4")
    early, late = (start_scenario(request.scenario, request.room) for _ in range(2))
    for t_s in np.arange(0.0, 1.5 * ROUND_S, 0.1):
        early.at(t_s)
    early.ended_contacts(1.5 * ROUND_S)
    for t_s in np.arange(1.5 * ROUND_S, 1.8 * ROUND_S, 0.04):
        one, other = early.at(t_s), late.at(t_s)
        for a, b in zip(one.hands, other.hands, strict=True):
            assert np.abs(a.joints - b.joints).max() < 1e-9
        for a, b in zip(early.ended_contacts(t_s), late.ended_contacts(t_s), strict=True):
            assert dataclasses.astuple(a) == pytest.approx(dataclasses.astuple(b))


def test_rounds_begin_and_end_without_a_hand_and_repeat_after_an_hour():
    request = parse_sim_url("sim:crossing,cameras=6,seed=2")
    width_mm, height_mm = canvas_mm(request.room.installation)
    assert (width_mm, height_mm) == (780.0, 340.0)
    first = start_scenario(request.scenario, request.room)
    for t_s in (0.0, ROUND_S - 0.1, 2.0 * ROUND_S, 3.0 * ROUND_S - 0.1):
        for hand in first.at(t_s).hands:
            assert hand.joints[..., 1].min() > height_mm + 150.0
    hour_later = start_scenario(request.scenario, request.room)
    again, now = (
        hour_later.at(ROUNDS * ROUND_S + 5.0),
        start_scenario(request.scenario, request.room).at(5.0),
    )
    for a, b in zip(again.hands, now.hands, strict=True):
        assert np.abs(a.joints - b.joints).max() < 3.0  # the tremor goes on


def test_hands_cross_each_seam_in_both_directions():
    request = parse_sim_url("sim:crossing,cameras=4,seed=5")
    scenario = start_scenario(request.scenario, request.room)
    places = [
        [hand.pad(Finger.INDEX)[:2] for hand in scenario.at(t_s).hands]
        for t_s in np.arange(3.0, 2.0 * ROUND_S, 0.07)
    ]
    tracks = np.array([each[0] for each in places if each])
    for axis, seam in ((0, 270.0), (1, 170.0)):
        side = np.sign(tracks[:, axis] - seam)
        assert min(np.count_nonzero(np.diff(side) > 0), np.count_nonzero(np.diff(side) < 0)) > 5


def test_wired_cameras_expose_one_after_the_other():
    room = parse_sim_url("sim:crossing,cameras=3").room
    clocks = clocks_of(room, "crossing")
    for index in (0, 1000):
        due = [1e6 * clock.exposed_s(index) for clock in clocks.values()]
        assert np.diff(due) == pytest.approx([160.0, 160.0])
    assert len({clock.start_us for clock in clocks.values()}) == 3
    assert len({clock.drift_ppm for clock in clocks.values()}) == 3
    recording = SimulatedRecording(
        parse_sim_url("sim:idle,cameras=3,camera=2,drop=0"), 0.1, colour=False, whole_ms=False
    )
    times = [frame.time_us - recording.clock.start_us for frame, _ in recording]
    assert times == pytest.approx([160, 33_506, 66_853], abs=2)  # its clock runs 0.4 permille fast


@pytest.mark.parametrize(
    ("apart_us", "share"),
    [(0.0, 1.0), (62.5, 0.5), (160.0, 0.0), (1575.0, 8 / 9), (-1575.0 * 8, 1 / 9), (14_000.0, 0.0)],
)
def test_lasers_share_light_while_both_are_on(apart_us, share):
    assert common_light(apart_us, 1450.0) == pytest.approx(share)


def test_in_the_wide_unbinned_mode_the_laser_pauses_for_longer():
    (clock, _) = clocks_of(
        parse_sim_url("sim:idle,cameras=2,mode=WFOV_UNBINNED").room, "idle"
    ).values()
    assert common_light(2515.0, clock.idle_us) == pytest.approx(8 / 9)
    assert common_light(1575.0, clock.idle_us) == 0.0


def shared(options, frames):
    room = parse_sim_url(f"sim:idle,cameras=2,{options}").room
    clocks = clocks_of(room, "idle")
    mine = clocks.pop(1)
    return [shares(mine, clocks, index).get(2, 0.0) for index in range(frames)]


def test_only_cameras_without_sync_or_delay_disturb_each_other():
    assert max(shared("sync=wired", 3000)) == 0.0
    assert min(shared("sync=wired,delay_us=0", 3000)) == pytest.approx(1.0)
    drifting = [np.array(shared(f"sync=none,seed={seed}", 30_000)) for seed in range(12)]
    assert 0.01 < np.mean(np.concatenate(drifting) > 0.0) < 0.4


def test_a_disturbed_frame_is_noisier_where_both_cameras_light_the_table():
    room = draw_room(3, **{"installation.cameras": 2, "sensor.illuminator_mm": 0.0})
    sensor = Sensor(room, colour_times=0)
    alone = np.stack([sensor.frame(time_us).depth for time_us in range(8)])
    disturbed = np.stack([sensor.frame(time_us, (), (), {2: 1.0}).depth for time_us in range(8)])
    x_mm = sensor._imager.view.x_mm
    near, far = (np.abs(x_mm - place) < 40.0 for place in (250.0, -130.0))
    middle = slice(250, 350)

    def noise(frames, where):
        depth = np.where(frames == 0, np.nan, frames.astype(float))[:, middle][:, where[middle]]
        return np.nanmedian(np.nanstd(depth, axis=0))

    assert noise(disturbed, near) > 3.0 * noise(alone, near)
    lost = [np.mean(frames[:, middle][:, near[middle]] == 0) for frames in (alone, disturbed)]
    assert lost[1] > lost[0] + 0.15
    assert noise(disturbed, far) == pytest.approx(noise(alone, far), rel=0.2)


def test_the_first_camera_of_several_is_the_single_camera():
    one, first, second = (
        Sensor(parse_sim_url(name).room, colour_times=0)
        for name in ("sim:idle", "sim:idle,cameras=2", "sim:idle,cameras=2,camera=2")
    )
    assert one.camera.serial == first.camera.serial != second.camera.serial
    frame, same, other = (each.frame(33_000) for each in (one, first, second))
    assert np.array_equal(frame.depth, same.depth)
    assert np.array_equal(frame.ir, same.ir)
    assert not np.array_equal(frame.depth, other.depth)


def test_the_layout_file_places_each_area_where_it_is(tmp_path):
    request = parse_sim_url("sim:crossing,cameras=6,angles_deg=0,180,90,2,-3,1,seed=8")
    path = tmp_path / "table.toml"
    path.write_text(layout_text(request))
    read = layout.load(path)
    assert (read.width_mm, read.height_mm) == (780.0, 340.0)
    for number, placed in enumerate(read.surface, 1):
        assert placed.node == f"camera-{number}"
        corner = np.array([*AREA_MM, 1.0])
        expected = request.room.place_of(number).canvas_from_surface @ [*AREA_MM, 0.0, 1.0]
        assert (placed.canvas_from_surface @ corner)[:2] == pytest.approx(expected[:2], abs=2e-3)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("crossing,cameras=7", "7 cameras; give 1 to 6"),
        ("crossing,cameras=0", "0 cameras; give 1 to 6"),
        ("crossing,camera=3", "number is 3; give 1 to 2"),
        ("crossing,sync=radio", "no sync 'radio'; choose from: wired, none"),
        ("crossing,delay_us=-1", "give 0 to 33333, one frame"),
        ("crossing,angles_deg=0,1,2", "3 angles_deg for 2 cameras"),
        ("drumming,cameras=2", "choose from: crossing, idle"),
    ],
)
def test_numbers_that_do_not_fit_get_one_sentence(name, says):
    with pytest.raises(UserError, match=says):
        parse_sim_url(f"sim:{name}")


@pytest.mark.long
def test_two_live_cameras_show_the_same_moment():
    requests = cameras("sim:crossing,cameras=2,camera={},drop=0,seed=3", 2)
    with VirtualKinect(requests[0], colour=False) as one:
        time.sleep(0.7)  # they need not start together
        with VirtualKinect(requests[1], colour=False) as two:
            times = [[], []]
            end = time.monotonic() + 6.0
            while time.monotonic() < end:
                for camera, seen in zip((one, two), times, strict=True):
                    frame = camera.read(0.01)
                    if frame is not None:
                        seen.append(frame.time_us)
    first, second = (np.array(each) for each in times)
    assert min(len(first), len(second)) > 30
    apart = second[:, None] - first[None]
    nearest = np.take_along_axis(apart, np.abs(apart).argmin(axis=1)[:, None], axis=1)
    assert np.median(nearest) == pytest.approx(160.0, abs=1.5)
