"""The truth of an installation: every pointing finger and every touch, in mm on the canvas.

Rule: for the evaluation and the truth file only. Time is host time in microseconds: 0 is when the
scenario begins; live, it is Unix time.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

from halo_service.values import Finger
from halo_service.virtual.installation.places import canvas_mm
from halo_service.virtual.motion import Contact
from halo_service.virtual.scenarios import start_scenario
from halo_service.virtual.sim_url import SimRequest
from halo_service.virtual.skeleton import PosedHand
from halo_service.virtual.truth import Line, side_name

STEP_S = 1.0 / 60.0
"""Between two lines: twice the cameras' rate, so that each frame has a near one."""


def canvas_request(request: SimRequest) -> SimRequest:
    """The same scenario seen in the canvas's own frame: by camera 1, not turned."""
    installation = dataclasses.replace(request.room.installation, camera=1, angles_deg=())
    room = dataclasses.replace(request.room, installation=installation)
    return dataclasses.replace(request, room=room)


def canvas_truth(request: SimRequest, seconds: float, start_s: float = 0.0) -> Iterator[Line]:
    """The lines of a period: one each `STEP_S`, and one for each touch when it has ended."""
    canvas = canvas_request(request)
    scenario = start_scenario(canvas.scenario, canvas.room)
    width_mm, height_mm = canvas_mm(canvas.room.installation)
    for index in range(round(seconds / STEP_S)):
        t_s = start_s + index * STEP_S
        hands = scenario.at(t_s).hands
        yield from (contact_line(each) for each in scenario.ended_contacts(t_s))
        fingers = [
            line
            for hand in hands
            for line in _fingers(hand)
            if 0.0 <= line["x_mm"] <= width_mm and 0.0 <= line["y_mm"] <= height_mm
        ]
        yield {"time_us": round(t_s * 1e6), "fingers": fingers}


def _fingers(hand: PosedHand) -> Iterator[Line]:
    for finger in Finger:
        if not hand.pointing(finger):
            continue
        x, y, z = hand.pad(finger).tolist()
        yield {
            "hand": side_name(hand.side),
            "finger": finger.name.lower(),
            "x_mm": round(x, 3),
            "y_mm": round(y, 3),
            "height_mm": round(max(0.0, -z), 3),
            "touching": hand.force_g[finger] > 0.0,
            "force_g": round(hand.force_g[finger], 2),
        }


def contact_line(contact: Contact) -> Line:
    """One touch, where it began."""
    return {
        "contact": {
            "hand": side_name(contact.side),
            "finger": contact.finger.name.lower(),
            "from_us": round(contact.from_s * 1e6),
            "to_us": round(contact.to_s * 1e6),
            "x_mm": round(contact.x_mm, 3),
            "y_mm": round(contact.y_mm, 3),
            "strike_mm_s": round(contact.strike_mm_s, 1),
            "peak_force_g": round(contact.peak_force_g, 1),
        }
    }


def layout_text(request: SimRequest, node: str = "camera") -> str:
    """The canvas's layout file, TOML: where the areas really are; nodes are NODE-1, NODE-2 ..."""
    room = request.room
    width_mm, height_mm = canvas_mm(room.installation)
    parts = [f"width_mm = {width_mm}\nheight_mm = {height_mm}\n"]
    for number in room.installation.numbers:
        place = room.place_of(number)
        parts.append(
            f'[[surface]]\nnode = "{node}-{number}"\nx_mm = {place.x_mm:.3f}\n'
            f"y_mm = {place.y_mm:.3f}\nangle_deg = {place.angle_deg:.4f}\n"
        )
    return "\n".join(parts)
