"""How often the hand tracker finds the virtual users' index finger: by curl, height and so on.

    uv run python benchmarks/tracked_hands.py [--users SEED ...] [--frames N]

Shows MediaPipe the blend of infrared and colour that the service gives it, for each user with
three curls under cameras at four heights. Prints the share of frames in which landmark 8 is within
30 mm of the true fingertip: in a video, and searched anew in each frame, as for a hand that has
just come. These are rendered hands: a person's may be found more often.
"""

from __future__ import annotations

import argparse
import os
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

os.environ["OMP_NUM_THREADS"] = "1"  # before the imports below: as the service has it

import cv2
import numpy as np

from halo_service.hand_tracking.blend import ColourWarp, blend
from halo_service.hand_tracking.hands import HandTracker
from halo_service.hand_tracking.model import hand_model
from halo_service.values import Finger
from halo_service.virtual.hand import pointing
from halo_service.virtual.materials import STUDIED
from halo_service.virtual.room import Room, draw_room
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sensor_model import TRUE
from halo_service.virtual.skeleton import FingerPose, PosedHand, posed

USERS = (213, 214, 215, 216, 217, 218)
"""Tuning users; the reported ones are for the report alone."""
CURLS, HEIGHTS_MM = (0.0, 0.5, 1.0), (350.0, 500.0, 700.0, 1000.0)
NEAR_MM, LANDMARK = 30.0, 8
FRAME_US = 33_333
ALIKE = 0.1
"""Skin within this share of the table's infrared counts as equally bright."""


@dataclass(frozen=True, slots=True)
class Seen:
    """One frame: its groups, and whether the finger was found."""

    groups: tuple[str, ...]
    in_video: bool
    anew: bool


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--users", type=int, nargs="+", default=USERS, metavar="SEED")
    parser.add_argument("--frames", type=int, default=24, help="of each film, default 24")
    given = parser.parse_args()
    cv2.setNumThreads(1)
    by_group: dict[str, list[Seen]] = defaultdict(list)
    for seed in given.users:
        for curl in CURLS:
            for height_mm in HEIGHTS_MM:
                room = draw_room(
                    seed,
                    sensor=TRUE,
                    material=STUDIED[seed % len(STUDIED)],
                    camera_height_mm=height_mm,
                    **{"user.curl": curl},
                )
                for seen in film(room, given.frames):
                    for group in seen.groups:
                        by_group[group].append(seen)
    print(f"{'found in % of frames':34} in a video   anew   frames")
    for group, frames in sorted(by_group.items()):
        in_video, anew = (
            100 * np.mean([getattr(each, how) for each in frames]) for how in ("in_video", "anew")
        )
        print(f"{group:34} {in_video:10.1f} {anew:6.1f} {len(frames):8}")


def film(room: Room, count: int) -> Iterator[Seen]:
    """Let one finger move over the table, tilting and turning, and look for it."""
    sensor = Sensor(room, colour_times=2)
    empty = sensor.frame(0).depth.astype(np.float32)
    warp = ColourWarp(sensor.camera, np.where(empty > 0, empty, room.camera_height_mm))
    trackers = [HandTracker(hand_model(None), max_hands=1) for _ in range(2)]
    nothing = np.zeros((*empty.shape, 3), np.uint8)
    reach_px = NEAR_MM * sensor.camera.depth.fx / room.camera_height_mm
    try:
        for number, aim in enumerate(aims(room, count)):
            hand = posed(room.user, pointing(room.user, room.dominant, aim, curl=room.user.curl))
            time_us = 1_000_000 + FRAME_US * number
            frame = sensor.frame(time_us, [hand])
            picture = blend(frame.ir, frame.colour, warp, frame.depth)
            trackers[1].find(nothing, time_us - FRAME_US // 2)  # it forgets the hand
            tip, *palm = pixels(sensor, hand)
            found = []
            for tracker in trackers:
                hands = tracker.find(picture, time_us).hands
                off = [np.hypot(*(each.landmarks_px[LANDMARK] - tip)) for each in hands]
                found.append(bool(min(off, default=np.inf) < reach_px))
            yield Seen((*groups(room), cut(sensor, palm)), *found)
    finally:
        for tracker in trackers:
            tracker.close()


def aims(room: Room, count: int) -> Iterator[FingerPose]:
    """A slow round over the table, low enough for a halo."""
    phase = np.random.default_rng(room.seed).uniform(0.0, 2.0 * np.pi, 3)
    for number in range(count):
        turn = 2.0 * np.pi * number / count
        pitch = 45.0 + 15.0 * float(np.sin(turn + phase[0]))
        yaw = room.seat_deg + 20.0 * float(np.sin(2.0 * turn + phase[1]))
        x = 150.0 + 120.0 * float(np.sin(turn + phase[2]))
        y = 100.0 + 75.0 * float(np.cos(turn + phase[2]))
        height = 6.0 + 6.0 * float(np.sin(3.0 * turn))
        yield FingerPose(x, y, height, 0.0, pitch, yaw)


def pixels(sensor: Sensor, hand: PosedHand) -> list[np.ndarray[tuple[int], np.dtype[np.float64]]]:
    """The fingertip, the wrist and the middle knuckle in the depth image."""
    points = np.stack([hand.joints[Finger.INDEX, 3], hand.palm[0], hand.palm[2]])
    return list(sensor.camera.depth.project(sensor.surface.to_camera(points)))


def groups(room: Room) -> tuple[str, ...]:
    """What the whole film has in common."""
    user, table = room.user, room.surface_material.infrared
    alike = abs(user.skin / table - 1.0) < ALIKE
    quarter = 90 * (round(room.seat_deg / 90.0) % 4)
    return (
        "all",
        f"curl {user.curl:g}",
        f"camera {room.camera_height_mm:4.0f} mm",
        f"curl {user.curl:g}, camera {room.camera_height_mm:4.0f} mm",
        f"seat about {quarter:3} degrees",
        f"skin {'like' if alike else 'unlike'} the table",
        f"user {room.seed} on {room.material}",
    )


def cut(sensor: Sensor, palm: list[np.ndarray[tuple[int], np.dtype[np.float64]]]) -> str:
    """How much of the hand the image's edge cuts off."""
    wrist, knuckle = (_inside(sensor, point) for point in palm)
    if wrist:
        return "whole hand in view"
    return "wrist cut off" if knuckle else "knuckles cut off"


def _inside(sensor: Sensor, px: np.ndarray[tuple[int], np.dtype[np.float64]]) -> bool:
    lens = sensor.camera.depth
    return bool(0 <= px[0] < lens.width and 0 <= px[1] < lens.height)


if __name__ == "__main__":
    main()
