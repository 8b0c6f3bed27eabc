"""Callbacks of the OSC In DAT `frames_in`: a table of pointers, and each touch once.

The first part is plain Python, in seconds and millimetres, and is tested without TouchDesigner.
The last part, from `onReceiveOSC` on, is called by TouchDesigner. Your own code goes into the Text
DAT `on_touch`.
"""

# No annotations: TouchDesigner's users read this file, and older versions have an older Python.
# ruff: noqa: ANN001, ANN201, ANN202, ANN204

import math
import re
from collections import namedtuple

NODE, SURFACE = "", ""
"""What to follow; empty: the first service that sends a frame."""
SLOTS = 10
COLUMNS = ("slot", "id", "touch", "u", "v", "x_mm", "y_mm", "hover_mm", "pressure", "force_g")
POINTER = (
    *("id", "slot", "hand", "finger", "touch", "u", "v", "x_mm", "y_mm", "hover_mm", "pressure"),
    *("vx_mm_s", "vy_mm_s", "confidence", "contacts", "force_g"),
)
"""The arguments of a pointer message, in order."""
NAME, SESSION = "[a-z0-9_-]{1,32}", "[g-z][a-z0-9_-]{0,31}"
MODULUS = 2**24
STALE_S = 1.0
"""After so long without an accepted frame, any frame number is accepted."""
LOST_S = 3.0
JOIN_MS = 200
"""Events so long before our first frame are late copies of what was earlier."""
UNKNOWN_STRIKE = -1.0
MAX_REMEMBERED = 256
"""Fingers that left and may still have repeated events."""

Touch = namedtuple("Touch", "kind id slot u v strike_mm_s contacts")
"""`kind` is "down" or "up"; `strike_mm_s` is -1 if unknown."""


class TouchCounter:
    """Each touch once: repeated events count once, lost ones are inferred from the pointers."""

    def __init__(self):
        self.fingers = {}  # id -> its place, and the last touches that began and ended

    def down(self, touch):
        finger = self._finger(touch)
        if touch.contacts <= finger["begun"]:
            return []
        ended = self._end(touch.id)
        finger.update(begun=touch.contacts, ended=touch.contacts - 1)
        return [*ended, touch]

    def up(self, touch, joining):
        finger = self._finger(touch)
        if touch.contacts <= finger["ended"]:
            return []
        if joining and touch.contacts > finger["begun"]:
            finger.update(begun=touch.contacts, ended=touch.contacts)  # It began before we joined.
            return []
        begun = self.down(touch._replace(kind="down", strike_mm_s=UNKNOWN_STRIKE))
        finger["ended"] = touch.contacts
        return [*begun, touch]

    def infer(self, pointers, joining):
        """The touches of a whole frame that no event has reported. `pointers`: dicts."""
        found = []
        for pointer in pointers:
            place = [pointer[name] for name in ("id", "slot", "u", "v")]
            touch = Touch("down", *place, UNKNOWN_STRIKE, pointer["contacts"])
            finger = self._finger(touch)
            if joining and touch.contacts > finger["begun"]:
                finger.update(begun=touch.contacts, ended=touch.contacts - pointer["touch"])
            found += self.down(touch)
            if not pointer["touch"]:
                found += self._end(touch.id)
        alive = {pointer["id"] for pointer in pointers}
        return found + self.end_all_but(alive)

    def end_all_but(self, alive):
        gone = [id_ for id_ in self.fingers if id_ not in alive]
        ended = [touch for id_ in gone for touch in self._end(id_)]
        for id_ in gone[:-MAX_REMEMBERED]:
            del self.fingers[id_]
        return ended

    def _finger(self, touch):
        finger = self.fingers.setdefault(touch.id, {"begun": 0, "ended": 0})
        finger["place"] = touch[1:5]
        return finger

    def _end(self, id_):
        finger = self.fingers[id_]
        if finger["ended"] >= finger["begun"]:
            return []
        finger["ended"] = finger["begun"]
        return [Touch("up", *finger["place"], UNKNOWN_STRIKE, finger["begun"])]


class Fingers:
    """The fingers of one service on one surface. Times are arguments, in seconds."""

    def __init__(self, node=NODE, surface=SURFACE):
        self.wanted = (node, surface)
        self.place = self.session = None
        self.bad = 0  # Messages that could not be read.
        self.retired = []  # Sessions that were replaced; some of their datagrams may be late.
        self._restart()

    def _restart(self):
        self.frame = self.scene = self.pins = self.joined_ms = None
        self.received_s = self.age_ms = 0.0
        self.accepting, self.joining = False, True
        self.count, self.pointers, self.arrived = 0, {}, {}
        self.touches = TouchCounter()

    def receive(self, address, arguments, now_s):
        """Process one message; return the touches that began or ended."""
        parts = address.split("/")
        if len(parts) != 5 or parts[1:3] != ["halo", "1"]:
            return []
        try:
            if not all(
                map(math.isfinite, (each for each in arguments if not isinstance(each, str)))
            ):
                raise ValueError("not finite")
            return self._receive(parts[3], parts[4], list(arguments), now_s)
        except (LookupError, TypeError, ValueError, ZeroDivisionError):
            self.bad += 1  # Any program can send to this port.
            return []

    def expire(self, now_s):
        """Return the touches that end because the service fell silent."""
        if self.place is None or now_s - self.received_s < LOST_S:
            return []
        ended = self.touches.end_all_but(())
        self.place = self.session = None
        self._restart()
        return ended

    def rows(self):
        """A row for each slot, as in the format `flat`: an empty slot has touch 0 and hover -1."""
        by_slot = {pointer["slot"]: pointer for pointer in self.pointers.values()}
        empty = dict.fromkeys(COLUMNS, 0) | {"id": -1, "hover_mm": -1, "force_g": -1}
        return [
            [slot, *(by_slot.get(slot, empty)[name] for name in COLUMNS[1:])]
            for slot in range(SLOTS)
        ]

    def _receive(self, surface, kind, arguments, now_s):
        if kind == "frame":
            return self._header(surface, arguments, now_s)
        if self.place is None or self.place[1] != surface:
            return []
        if kind in ("scene", "homography"):
            self._report(kind, arguments)
        if not self.accepting:
            return []
        if kind == "pointer":
            pointer = dict(zip(POINTER, arguments))  # noqa: B905 - later versions append arguments
            self.arrived[pointer["id"]] = pointer
        elif kind == "alive":
            return self._alive(arguments)
        elif kind == "down" and arguments[5] <= self.age_ms + JOIN_MS:
            return self.touches.down(Touch("down", *arguments[:5], arguments[6]))
        elif kind == "up" and arguments[4] <= self.age_ms + JOIN_MS:
            up = Touch("up", *arguments[:4], UNKNOWN_STRIKE, arguments[5])
            return self.touches.up(up, self.joining)
        return []

    def _header(self, surface, arguments, now_s):
        node, session, number, time_s, time_frac_us, count = arguments[:6]
        if not (re.fullmatch(NAME, node) and re.fullmatch(SESSION, session)):
            raise ValueError("invalid name")
        ended = self.expire(now_s)
        self.accepting = False
        if self.place is None and self.wanted[0] in ("", node) and self.wanted[1] in ("", surface):
            self.place, self.session = (node, surface), session
        if self.place != (node, surface):
            return ended
        if session != self.session:
            if session in self.retired:
                return ended
            ended += self.touches.end_all_but(())
            self.retired = [*self.retired[-63:], self.session]
            self._restart()
            self.session = session
        ahead = 1 if self.frame is None else (number - self.frame) % MODULUS
        if ahead < MODULUS // 2 or now_s - self.received_s > STALE_S:
            if ahead:  # Else another part of the same frame.
                self.arrived = {}
            self.accepting, self.received_s = True, now_s
            self.frame, self.count = number, count
            time_ms = time_s * 1000 + time_frac_us / 1000
            self.joined_ms = time_ms if self.joined_ms is None else self.joined_ms
            self.age_ms = time_ms - self.joined_ms
        return ended

    def _alive(self, ids):
        """Use the pointers that have arrived; others stay where they were, if they are alive."""
        known = self.pointers | self.arrived
        self.pointers = {id_: known[id_] for id_ in ids if id_ in known}
        if len(self.arrived) < self.count:
            return []  # A part is missing: the next frame repeats its events.
        found = self.touches.infer(list(self.pointers.values()), self.joining)
        self.joining = False
        return found

    def _report(self, kind, arguments):
        if arguments[:2] != [self.place[0], self.session]:
            return
        if kind == "scene":
            self.scene = {"size_mm": arguments[3:5], "revision": arguments[6]}
        elif self.scene and arguments[2] == self.scene["revision"]:
            self.pins = pins(arguments[5:14], arguments[3:5], self.scene["size_mm"])


def pins(projector_from_surface, size_px, size_mm):
    """Return the projector's corners in a picture of the surface, for a Corner Pin TOP.

    The picture covers the surface, left to right and far to near edge. Each corner (1 top left,
    2 top right, 3 bottom left, 4 bottom right) is in fractions of the picture, (0, 0) bottom left.
    """
    rows = adjugate(projector_from_surface)
    width_px, height_px = size_px
    corners = {1: (0, 0), 2: (width_px, 0), 3: (0, height_px), 4: (width_px, height_px)}
    found = {}
    for number, (x_px, y_px) in corners.items():
        x, y, w = (a * x_px + b * y_px + c for a, b, c in rows)
        found[number] = (x / w / size_mm[0], 1 - y / w / size_mm[1])
    return found


def adjugate(matrix):
    """Return the inverse of a homography (9 numbers, row by row) as 3 rows, at another scale."""
    a, b, c, d, e, f, g, h, i = matrix
    return (
        (e * i - f * h, c * h - b * i, b * f - c * e),
        (f * g - d * i, a * i - c * g, c * d - a * f),
        (d * h - e * g, b * g - a * h, a * e - b * d),
    )


# TouchDesigner calls what follows. README.md says what was not run inside TouchDesigner.

fingers = Fingers()
MAX_HITS = 50


def onReceiveOSC(dat, rowIndex, message, byteData, timeStamp, address, args, peer):  # noqa: N802, N803
    show(dat.parent(), fingers.receive(address, args, absTime.seconds))  # noqa: F821
    if address.endswith("/alive"):
        write_pointers(dat.parent().op("pointers"), fingers.rows())
    elif address.endswith("/homography") and fingers.pins:
        pin(dat.parent().op("projector"), fingers.pins)


def tick(comp):
    """Called in each frame by the Execute DAT `tick`: notices a service that fell silent."""
    show(comp, fingers.expire(absTime.seconds))  # noqa: F821
    if fingers.place is None:
        write_pointers(comp.op("pointers"), fingers.rows())


def show(comp, touches):
    for touch in touches:
        hits = comp.op("hits")
        hits.appendRow([rounded(value) for value in touch])
        if hits.numRows > MAX_HITS + 1:
            hits.deleteRow(1)
        handlers = comp.op("on_touch").module
        (handlers.onDown if touch.kind == "down" else handlers.onUp)(touch)


def write_pointers(table, rows):
    for number, row in enumerate(rows, 1):
        for column, value in enumerate(map(rounded, row)):
            if table[number, column] != str(value):  # Else all that reads the cell cooks again.
                table[number, column] = value


def rounded(value):
    return round(value, 4) if isinstance(value, float) else value


def pin(corner_pin, corners):
    for number, place in corners.items():
        for value, names in zip(place, ("x1", "y2"), strict=True):
            # Derivative's pages name them extractp11, projects use extractp1x.
            corner_pin.pars(f"extractp{number}[{names}]")[0].val = value
