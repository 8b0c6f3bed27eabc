"""What the virtual camera measures: hands in a room to the frame that an SDK would hand us.

Rule: a frame is a function of (room, time, what is in view): no hidden state, so the same seed
gives the same bytes in any order; only live, noise also depends on the frames before. The truth
stays outside: nothing of it is in the frame.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from halo_service.values import Frame
from halo_service.virtual import bodies as shapes
from halo_service.virtual.bodies import Body
from halo_service.virtual.boxes import Box, clipped, union, within
from halo_service.virtual.colour_image import Bgr, ColourImager
from halo_service.virtual.dents import halo_parts
from halo_service.virtual.depth_image import DepthImager, Ideal
from halo_service.virtual.exposure import EDGE_STEP_MM
from halo_service.virtual.halo import fading
from halo_service.virtual.installation.interference import Interference
from halo_service.virtual.live_noise import LiveElectronics
from halo_service.virtual.noise import Electronics
from halo_service.virtual.optics import (
    AVERAGED,
    WIDEST_SHADOW_PX,
    Places,
    add_stray_light,
    cast_shadow,
    soften_edges,
)
from halo_service.virtual.room import Room
from halo_service.virtual.skeleton import PosedHand, User

NO_LIGHT: Mapping[int, float] = {}


class Sensor:
    """A virtual camera over one room.

    `colour_times` draws the colour image at that fraction of its size and enlarges it (live);
    1 is full quality, 0 switches colour off. `started_us` is when the device was switched on.
    `live`: frames follow each other, and noise of the empty room returns; see `live_noise`.
    Raises UserError where the room asks for a picture that cannot be read.
    """

    def __init__(
        self, room: Room, *, colour_times: int = 1, started_us: int = 0, live: bool = False
    ) -> None:
        self.room = room
        self._user = _as_read(room)
        self.camera = room.camera()
        self.surface = room.surface()
        self._started_us = started_us
        with ThreadPoolExecutor(1, "colour") as other_core:
            colour = other_core.submit(self._colour_imager, colour_times)
            self._imager = DepthImager(room, self.camera, self.surface)
        self._colour = colour.result()
        self._fade = fading(room.camera_height_mm, room.camera_yaw_deg, room.camera_pitch_deg)
        electronics = LiveElectronics if live else Electronics
        self._electronics = electronics(room, self.camera, self._imager.empty)
        self._interference = (
            None
            if room.installation.alone
            else Interference(room, self.camera.depth, self._imager.view)
        )
        self._colour_times = colour_times
        self._shown: Bgr | None = None
        self._draws_colour = True

    def _colour_imager(self, times: int) -> ColourImager | None:
        return ColourImager(self.room, self.camera, self.surface, times) if times else None

    def with_colour(self, wanted: bool) -> None:
        """Draw colour or leave it out from now on; depth and infrared stay the same."""
        self._draws_colour = wanted

    def show(self, picture: Bgr | None) -> None:
        """Let the projector show a picture, (h, w, 3) of its size, from now on; None: it is off.

        The room's own picture is forgotten.
        """
        self._shown = picture
        if self._colour is not None:
            self._colour.throw(picture)

    def furnish(self, room: Room) -> None:
        """Change what lies in the room or how its colour camera is set; the place stays.

        Takes as long as making a sensor; the projector goes on with what `show` gave it.
        """
        self.room = room
        self._user = _as_read(room)
        self._imager = DepthImager(room, self.camera, self.surface)
        self._electronics.furnish(self._imager.empty)
        self._colour = self._colour_imager(self._colour_times)
        if self._colour is not None and self._shown is not None:
            self._colour.throw(self._shown)

    def frame(
        self,
        time_us: int,
        hands: Sequence[PosedHand] = (),
        things: Sequence[Body] = (),
        shared_light: Mapping[int, float] = NO_LIGHT,
    ) -> Frame:
        """The frame exposed at `time_us` with these hands and things in view.

        `shared_light`: of the other cameras of the installation, see `interference.shares`.
        """
        rng = np.random.default_rng([*self.room.noise_seed, time_us])
        seen = [*(shapes.of_hand(self._user, hand) for hand in hands), *things]
        velocities = [*(hand.velocity_mm_s for hand in hands), *([np.zeros(3)] * len(things))]
        age_s = (time_us - self._started_us) / 1e6
        ideal = self._imager.draw(seen, velocities)
        lost, changed = self._through_optics(ideal, hands, rng)
        depth = self._electronics.depth(ideal, changed, age_s, rng)
        for places in lost:
            depth[places] = 0
        if self._interference is not None:
            self._interference.disturb(depth, shared_light, rng)
        infrared = self._electronics.infrared(ideal, rng)
        self._imager.wipe(changed)
        return Frame(time_us, depth, infrared, self._picture(age_s, seen, velocities, rng))

    def _through_optics(
        self, ideal: Ideal, hands: Sequence[PosedHand], rng: np.random.Generator
    ) -> tuple[list[Places], Box | None]:
        """Add what light does on its way, in place.

        Return where nothing can be read, and what differs from the empty room.
        """
        table, model, lens = self._imager.table, self.room.sensor, self.camera.depth
        shadow = cast_shadow(ideal, table, model, lens, rng)
        edges = soften_edges(ideal, table, model, rng)
        changed = [*self._dent(hands, ideal), add_stray_light(ideal, table, model, lens)]
        changed.append(ideal.around(WIDEST_SHADOW_PX))
        return [lost for lost in (edges, shadow) if lost is not None], union(changed)

    def _dent(self, hands: Sequence[PosedHand], ideal: Ideal) -> list[Box]:
        """Press the halo into the table around every finger, in place; return where."""
        view = self._imager.view
        dented = []
        for part in halo_parts(self.room, hands, self._fade):
            places = np.column_stack([part.places_mm, np.zeros(len(part.places_mm))])
            px = self.camera.depth.project(self.surface.to_camera(places))
            # In pixels; a margin for the lens's distortion and for a table that comes nearer.
            reach = 1.15 * part.reach_mm * self.camera.depth.fx / self.room.camera_height_mm
            boxes = [clipped(at - reach, at + reach, ideal.depth.shape) for at in px]
            box = union(boxes)
            if box is None or view.x_mm[box].size == 0:
                continue
            parts = [within(each, box) for each in boxes]
            field = part.field(view.x_mm[box], view.y_mm[box], parts)
            field *= self._imager.top.halo[box]
            field *= self._dented_share(ideal, box)
            ideal.depth[box] += field
            dented.append(box)
        return dented

    def _dented_share(self, ideal: Ideal, box: Box) -> NDArray[np.float32]:
        """How much of a dent is seen at each pixel of a box, 0 to 1.

        Skin is not dented, but a low finger's averaged pixels share what lies around them.
        """
        share = self._imager.table[box] - ideal.depth[box]
        share += ideal.late[box]
        share /= np.float32(EDGE_STEP_MM)
        np.subtract(np.float32(1.0), share, out=share)
        share *= np.float32(AVERAGED)
        np.clip(share, 0.0, 1.0, out=share)
        np.copyto(share, 1.0, where=ideal.covered[box] == 0)
        return share

    def _picture(
        self,
        t_s: float,
        seen: Sequence[Body],
        velocities: Sequence[NDArray[np.float64]],
        rng: np.random.Generator,
    ) -> Bgr | None:
        if self._colour is None or not self._draws_colour:
            return None
        image = self._colour.draw(t_s, seen, velocities)
        self._electronics.grain(image, rng)
        return self._colour.enlarge(image)


def _as_read(room: Room) -> User:
    """The user, with as much of the skin's offset as this sensor shows."""
    offset_mm = room.user.skin_offset_mm * room.sensor.skin_times
    return dataclasses.replace(room.user, skin_offset_mm=offset_mm)
