"""What late joiners receive: the scene, and where camera, projector and marker are."""

from __future__ import annotations

import time
from dataclasses import replace
from importlib.metadata import version

import numpy as np
import pytest

import halo_protocol as wire
from halo_service.app.service.publisher import Publisher
from halo_service.host_clock import HostClock
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.outgoing import Outgoing
from halo_service.profile import Anchor, Profile, Projector, StepRecord
from halo_service.runtime.health import Health
from halo_service.sensing import SensingSettings, start
from halo_service.values import TouchFrame

MATRIX = np.array([[4.0, 0.4, 20.0], [0.1, 3.6, 30.0], [0.0002, 0.0006, 1.0]])


class Heard:
    """A carrier that keeps what it is given."""

    def __init__(self) -> None:
        self.messages: dict[str, wire.Message] = {}

    def send(self, outgoing: Outgoing) -> None:
        *_, (_, message) = wire.decode(outgoing.datagrams[0])
        self.messages[outgoing.kind] = message

    def close(self) -> None:
        """Nothing to let go."""


class Broken:
    """A carrier that fails at each message."""

    def send(self, outgoing: Outgoing) -> None:
        raise RuntimeError("no route")

    def close(self) -> None:
        """Nothing to close."""


def published(profile: Profile | None, profile_camera) -> dict[str, wire.Message]:
    heard = Heard()
    publisher = Publisher(
        FrameEncoder("desk", "s1", 0), [heard], "virtual", profile_camera, "table"
    )
    publisher.scene(start(profile, SensingSettings()))
    return heard.messages


def test_nothing_is_said_of_what_is_not_known(profile: Profile, camera) -> None:
    assert set(published(None, camera)) == {"scene"}
    heard = published(profile, camera)
    assert set(heard) == {"scene", "pose"}
    assert heard["pose"].anchored == 0
    assert heard["pose"].anchor_from_surface == (0.0,) * 12


def test_the_scene_names_the_versions_of_service_and_zenoh(camera) -> None:
    heard = Heard()
    publisher = Publisher(
        FrameEncoder("desk", "s1", 0), [heard], "virtual", camera, "table", zenoh_version="1.2.3"
    )
    publisher.scene(start(None, SensingSettings()))
    scene = heard.messages["scene"]
    assert (scene.service_version, scene.zenoh_version) == (version("halo-service"), "1.2.3")


@pytest.mark.parametrize(
    ("dates", "unix_s"),
    [
        ({}, 0),
        ({"touch": "1970-01-02T00:00:00Z", "sweep": "1970-01-02T00:00:05Z"}, 86_405),
        ({"touch": "1970-01-02T00:00:00Z", "verify": "1970-01-03T00:00:00Z"}, 86_400),
        ({"touch": "yesterday"}, 0),
    ],
)
def test_the_scene_dates_the_newest_step_that_changes_touches(
    profile: Profile, camera, dates: dict[str, str], unix_s: int
) -> None:
    steps = {name: StepRecord(date, "good", {}) for name, date in dates.items()}
    heard = published(replace(profile, steps=steps), camera)
    assert heard["scene"].calibrated_s == unix_s
    assert published(None, camera)["scene"].calibrated_s == 0


def test_projector_and_anchor_go_out_with_the_scenes_revision(profile: Profile, camera) -> None:
    anchor_from_surface = np.eye(4)
    anchor_from_surface[:3, 3] = (-40.0, -60.0, 10.0)
    known = replace(
        profile,
        revision=7,
        projector=Projector(1280, 800, MATRIX),
        anchor=Anchor("apriltag-36h11", 0, 80.0, anchor_from_surface),
    )
    heard = published(known, camera)
    assert {message.revision for message in heard.values()} == {7}
    homography, pose = heard["homography"], heard["pose"]
    assert (homography.width_px, homography.height_px) == (1280, 800)
    assert homography.projector_from_surface == pytest.approx(tuple(MATRIX.ravel()))
    assert pose.anchored == 1
    assert pose.anchor_from_surface == pytest.approx(tuple(anchor_from_surface[:3].ravel()))
    assert pose.camera_from_surface == pytest.approx(
        tuple(profile.surface.camera_from_surface[:3].ravel())
    )


def test_a_carrier_that_fails_does_not_stop_the_others(camera, caplog) -> None:
    heard = Heard()
    carriers = [Broken(), heard, Broken()]
    publisher = Publisher(FrameEncoder("desk", "s1", 0), carriers, "virtual", camera, "table")
    for _ in range(3):
        publisher.frame(TouchFrame(0, "table", 300.0, 200.0))
        publisher.scene(start(None, SensingSettings()))
    assert set(heard.messages) == {"frame", "scene"}
    assert [each.getMessage() for each in caplog.records if each.exc_info] == [
        "output Broken failed: RuntimeError: no route; this kind of error is logged once"
    ]


def test_health_reports_what_is_wrong_around_the_sensing(camera) -> None:
    heard = Heard()
    publisher = Publisher(
        FrameEncoder("desk", "s1", 0),
        [heard],
        "virtual",
        camera,
        "table",
        write_errors=lambda: 2,
        zenoh_missing=lambda: 1,
    )
    current = Health(30.0, 1.0, 0, 0, "off", "running", -1.0, 412, "least", 4.5)
    publisher.health(current)
    health = heard.messages["health"]
    assert (health.load, health.looks_hz) == (wire.Load.LEAST, 4.5)
    assert (health.zenoh_missing, health.write_errors, health.memory_mb) == (1, 2, 412)
    assert health.time_s + health.time_frac_us / 1e6 == pytest.approx(time.time(), abs=60.0)


def test_health_reads_the_hosts_clock_also_where_no_source_does(
    camera, monkeypatch: pytest.MonkeyPatch
) -> None:
    unix_ns = [10**18]
    clock = HostClock(lambda: unix_ns[0], lambda: 0)
    monkeypatch.setattr("halo_service.app.service.publisher.CLOCK", clock)
    heard = Heard()
    publisher = Publisher(FrameEncoder("desk", "s1", 0), [heard], "virtual", camera, "table")
    current = Health(30.0, 1.0, 0, 0, "off", "running", -1.0)
    publisher.health(current)
    assert (heard.messages["health"].clock_jumps, heard.messages["health"].clock_error_ms) == (0, 0)
    unix_ns[0] -= 30 * 10**9
    publisher.health(current)
    assert heard.messages["health"].clock_jumps == 1
    assert heard.messages["health"].clock_error_ms == -30_000.0
