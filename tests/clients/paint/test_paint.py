"""Touches become strokes, strokes become pictures: soft, curved, equal as PNG and SVG."""

from __future__ import annotations

import math
from collections.abc import Callable
from io import BytesIO
from typing import Any

import numpy as np
import pygame
import pytest
import resvg_py
from numpy.typing import NDArray
from scipy.stats import spearmanr

import halo_client
from halo_client import FileSource, PictureTransform
from halo_paint.brushes import BRUSHES, COLOURS, PAPER
from halo_paint.canvas import Canvas
from halo_paint.painter import Change, Painter
from halo_paint.palette import CELLS, Action
from halo_paint.render import painted, save, to_pixels
from halo_paint.stroke import Stroke, whole
from halo_paint.svg import to_svg
from halo_protocol import Homography, TouchFrame
from tests.kind_sensor import KIND_URL

SIZE = (300.0, 200.0)


def arc(wire: Any, contacts: int = 1, count: int = 40, strength: float = 1.2) -> list[TouchFrame]:
    """A finger draws a half circle, pressing softly, hard, softly, and hovers away."""
    frames = []
    for n in range(count):
        angle = math.pi * n / (count - 1)
        at = (150 - 80 * math.cos(angle), 130 - 80 * math.sin(angle))
        pressure = 0.1 + strength * math.sin(angle)
        pointer = wire.finger(at=at, pressure=pressure, contacts=contacts)
        events = {"downs": (wire.down(at=at, contacts=contacts, ago_ms=0.0),)} if n == 0 else {}
        frames.append(wire.frame(n, [pointer], **events))
    gone = wire.finger(at=at, hover_mm=9.0, contacts=contacts)
    frames.append(wire.frame(count, [gone], ups=(wire.up(at=at, contacts=contacts),)))
    return frames


def tap(wire: Any, u: float, v: float, contacts: int = 1) -> TouchFrame:
    at = (u * SIZE[0], v * SIZE[1])
    begin, end = wire.down(at=at, contacts=contacts), wire.up(at=at, contacts=contacts)
    return wire.frame(0, [], downs=(begin,), ups=(end,))


def middle(means: Any) -> tuple[float, float]:
    left, far, right, near = next(cell.area for cell in CELLS if cell.means == means)
    return (left + right) / 2, (far + near) / 2


def rasterised(svg: str, width_px: int) -> NDArray[np.uint8]:
    png = bytes(resvg_py.svg_to_bytes(svg_string=svg, width=width_px, dpi=96.0))
    return pygame.surfarray.array3d(pygame.image.load(BytesIO(png))).swapaxes(0, 1)


def similarity(one: NDArray[np.uint8], other: NDArray[np.uint8]) -> tuple[float, float]:
    """Structural similarity (Wang et al. 2004), of the whole picture and of what is painted."""
    import cv2

    a, b = (picture.mean(axis=2) for picture in (one, other))

    def blur(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return cv2.GaussianBlur(x, (11, 11), 1.5)

    mean_a, mean_b = blur(a), blur(b)
    var_a, var_b = blur(a * a) - mean_a**2, blur(b * b) - mean_b**2
    both = blur(a * b) - mean_a * mean_b
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    map_ = (2 * mean_a * mean_b + c1) * (2 * both + c2)
    map_ /= (mean_a**2 + mean_b**2 + c1) * (var_a + var_b + c2)
    inked = np.abs(a - np.mean(PAPER)) > 8
    return float(map_.mean()), float(map_[inked].mean())


@pytest.mark.parametrize("brush", BRUSHES, ids=lambda brush: brush.name)
def test_more_pressure_is_wider_and_denser(wire: Any, brush: Any) -> None:
    (stroke,) = painted(arc(wire), Painter(brush=brush))
    piece = whole(stroke)
    middle_of = slice(len(piece.x) * 4 // 10, len(piece.x) * 6 // 10)
    ends = np.r_[: len(piece.x) // 10, -len(piece.x) // 10 : 0]
    assert piece.ink[middle_of].mean() > piece.ink[ends].mean()
    if brush.nib_deg is None:
        assert piece.radius[middle_of].min() > 1.5 * piece.radius[ends].max()
    assert 2 * piece.radius.max() <= brush.thick_mm


def test_a_broad_nib_is_thin_along_itself(wire: Any) -> None:
    nib = next(brush for brush in BRUSHES if brush.nib_deg is not None)
    widths = []
    for degrees in (nib.nib_deg, nib.nib_deg + 90):
        stroke, turn = Stroke(nib, COLOURS[0], 1), math.radians(degrees)
        for n in range(20):
            stroke.add(100 + 4 * n * math.cos(turn), 100 + 4 * n * math.sin(turn), 0.8, n * 33_333)
        stroke.end()
        widths.append(float(whole(stroke).radius[-20:].mean()))
    assert widths[1] > 3 * widths[0]


def test_the_curve_is_smooth_and_near_the_path(wire: Any) -> None:
    (stroke,) = painted(arc(wire, count=16), Painter())
    piece = whole(stroke)
    away = np.hypot(piece.x - 150, piece.y - 130) - 80
    assert np.abs(away).max() < 1.0
    moving = np.hypot(np.diff(piece.x), np.diff(piece.y)) > 1e-3
    turns = np.abs(np.angle(np.exp(1j * np.diff(piece.direction))))[moving]
    assert np.degrees(turns[3:-3].max()) < 4.0, "no visible corner"


def test_finished_pieces_never_change(wire: Any) -> None:
    painter = Painter()
    seen: list[Any] = []
    for frame in arc(wire):
        for change, stroke in painter.process(frame):
            if change is Change.GREW:
                assert [id(piece) for piece in stroke.pieces[: len(seen)]] == seen
                seen = [id(piece) for piece in stroke.pieces]


def test_a_stroke_does_not_end_in_a_hook(wire: Any) -> None:
    frames = arc(wire)[:-1]
    for n in range(3):
        frames.append(
            wire.frame(40 + n, [wire.finger(at=(230 + 8 * n, 110 - 8 * n), pressure=0.02)])
        )
    frames.append(wire.frame(43, [], ups=(wire.up(),)))
    (stroke,) = painted(frames, Painter())
    assert float(whole(stroke).x.max()) < 231.0


def test_a_touch_on_the_palette_chooses_and_does_not_paint(wire: Any) -> None:
    painter = Painter()
    for number, means in enumerate([COLOURS[5], BRUSHES[2]]):
        assert painter.process(tap(wire, *middle(means), contacts=number + 1)) == []
    assert (painter.colour, painter.brush, painter.strokes) == (COLOURS[5], BRUSHES[2], [])


def test_undo_goes_back_over_a_clear(wire: Any) -> None:
    painter = Painter()
    for contacts in (1, 2):
        painted(arc(wire, contacts), painter)
    counts = []
    for number, action in enumerate(
        [Action.CLEAR, Action.UNDO, Action.UNDO, Action.UNDO, Action.UNDO]
    ):
        painter.process(tap(wire, *middle(action), contacts=10 + number))
        counts.append(len(painter.strokes))
    assert counts == [0, 2, 1, 0, 0]


def test_undo_shows_the_picture_before_while_another_finger_paints(wire: Any) -> None:
    """Three strokes that cross, then undo step by step; an open stroke lies over all of them."""
    placing = PictureTransform.fitted(300, 200, *SIZE)
    painter, live = Painter(), Canvas(300, 200, placing)
    open_frames = arc(wire)[:20]
    for contacts in (1, 2, 3):
        for frame in arc(wire, contacts, count=20 + 8 * contacts):
            for change, stroke in painter.process(frame):
                if change is Change.GREW:
                    live.grow(stroke)
                elif change is Change.ENDED:
                    live.dry(stroke)
    other = Painter(brush=BRUSHES[1])
    for frame in open_frames:
        for _, stroke in other.process(frame):
            live.grow(stroke)
    areas = []
    for left in (2, 1, 0, 0):
        painter.undo()
        box = live.undo(painter.strokes)
        assert len(painter.strokes) == left
        anew = Canvas(300, 200, placing)
        anew.repaint(painter.strokes)
        anew.grow(stroke)
        assert np.array_equal(live.pixels, anew.pixels)
        areas.append((box[0].stop - box[0].start) * (box[1].stop - box[1].start))
    assert max(areas[:3]) < areas[3] == 300 * 200, "only the last one, without a stroke, draws all"


def test_a_lost_service_ends_its_strokes(wire: Any) -> None:
    painter = Painter()
    painted(arc(wire)[:20], painter)
    assert painter.strokes == []
    painter.process(wire.frame(20, [], ups=(wire.up(),)))
    assert [stroke.done for stroke in painter.strokes] == [True]


def test_a_stroke_can_cross_itself_without_a_seam(wire: Any) -> None:
    pen = BRUSHES[1]
    stroke = Stroke(pen, (0, 0, 0), 1)
    for n, at in enumerate([(50, 50), (150, 150), (150, 50), (50, 150)]):
        stroke.add(*at, 0.2, n * 1_000_000)
    stroke.end()
    pixels = to_pixels([stroke], *SIZE, width_px=600)
    darkest = pixels.min()
    alone = Stroke(pen, (0, 0, 0), 1)
    for n, at in enumerate([(50, 50), (150, 150)]):
        alone.add(*at, 0.2, n * 1_000_000)
    alone.end()
    assert abs(int(to_pixels([alone], *SIZE, width_px=600).min()) - int(darkest)) <= 2


@pytest.mark.parametrize("brush", BRUSHES, ids=lambda brush: brush.name)
def test_edges_are_soft_over_one_pixel(brush: Any) -> None:
    stroke = Stroke(brush, (0, 0, 0), 1)
    for n in range(30):
        stroke.add(40 + 7 * n, 60 + 2 * n, 1.0, n * 33_333)
    stroke.end()
    pixels = to_pixels([stroke], *SIZE, width_px=900)[..., 0].astype(float)
    steps = np.abs(np.diff(pixels, axis=0)).max(axis=0)[150:600]
    assert np.unique(pixels).size > 10
    assert np.median(steps) < 245, "a hard edge would jump from paper to ink"


def test_live_and_rendered_are_the_same_picture(wire: Any) -> None:
    painter = Painter(vary=True)
    canvas = Canvas(900, 600, PictureTransform.fitted(900, 600, *SIZE))
    for contacts in (1, 2, 3):
        for frame in arc(wire, contacts):
            for change, stroke in painter.process(frame):
                if change is Change.GREW:
                    canvas.grow(stroke)
                elif change is Change.ENDED:
                    canvas.dry(stroke)
    assert np.array_equal(canvas.pixels, to_pixels(painter.strokes, *SIZE, width_px=900))


def svg_against_png(wire: Any, brush: Any) -> tuple[float, float]:
    """Structural similarity over the whole picture, and over its painted parts."""
    strokes = painted(arc(wire), Painter(brush=brush))
    return similarity(
        to_pixels(strokes, *SIZE, width_px=1200), rasterised(to_svg(strokes, *SIZE), 1200)
    )


@pytest.mark.parametrize("brush", BRUSHES, ids=lambda brush: brush.name)
def test_svg_and_png_agree(wire: Any, brush: Any) -> None:
    whole_picture, _ = svg_against_png(wire, brush)
    assert whole_picture >= 0.97


@pytest.mark.parametrize("brush", BRUSHES, ids=lambda brush: brush.name)
def test_svg_and_png_agree_where_paint_is(wire: Any, brush: Any) -> None:
    _, painted_parts = svg_against_png(wire, brush)
    print(f"{brush.name}: {painted_parts:.3f}")
    assert painted_parts >= 0.9


def test_on_the_projector_paint_is_where_the_finger_is(wire: Any) -> None:
    matrix = (4.5, 0.4, 120.0, -0.3, 4.6, 90.0, 1e-4, -2e-4, 1.0)
    placing = PictureTransform.projected(
        Homography("desk", "s1", 0, 1920, 1080, matrix), 1920, 1080
    )
    canvas = Canvas(1920, 1080, placing)
    strokes = painted(arc(wire), Painter(brush=BRUSHES[1]))
    canvas.repaint(strokes)
    inked = np.abs(canvas.pixels.astype(int) - PAPER).max(axis=2) > 60
    v, u = np.nonzero(inked)
    surface_from_projector = np.linalg.inv(np.array(matrix).reshape(3, 3))
    back = surface_from_projector @ np.stack([u + 0.5, v + 0.5, np.ones(len(u))])
    x, y = back[:2] / back[2]
    assert np.abs(np.hypot(x - 150, y - 130) - 80).max() < 3.0


def test_a_picture_that_is_neither_png_nor_svg_is_refused(wire: Any, tmp_path: Any) -> None:
    with pytest.raises(ValueError, match="neither"):
        save(tmp_path / "it.gif", [], *SIZE)


def test_strokes_follow_the_true_path_and_force(wire: Any) -> None:
    """The input is the virtual painter's true path and force, as from a service without error."""
    from halo_service.values import Finger
    from halo_service.virtual.scenarios import start_scenario
    from halo_service.virtual.sim_url import parse_sim_url

    request = parse_sim_url(f"sim:painting?seed=3&{KIND_URL}")
    motion = start_scenario(request.scenario, request.room)
    painter, contacts, before = Painter(), 0, False
    true: list[tuple[float, float]] = []
    widths: list[float] = []
    forces: list[float] = []
    for number in range(600):
        (hand,) = motion.at(number / 30).hands
        x, y, _ = (float(v) for v in hand.pad(Finger.INDEX))
        force = float(hand.force_g[Finger.INDEX])
        contacts += force > 0 and not before
        events: dict[str, Any] = {}
        if force > 0 and not before:
            events["downs"] = (wire.down(at=(x, y), contacts=contacts, ago_ms=0.0),)
        if before and force <= 0:
            events["ups"] = (wire.up(at=(x, y), contacts=contacts),)
        # 25 g is the calibrated touch and 200 g the press, so pressure is exact.
        pressure = max(0.02, (force - 25) / 175) if force > 0 else None
        pointer = wire.finger(at=(x, y), pressure=pressure, contacts=contacts)
        news = painter.process(wire.frame(number, [pointer], **events))
        if force > 0:
            true.append((x, y))
            grown = [stroke for change, stroke in news if change is Change.GREW]
            if grown and force > 25 and before:
                widths.append(2 * float(grown[0].pieces[-1].radius[-1]))
                forces.append(force)
        before = force > 0
    path = np.array(true)
    errors = []
    for stroke in painter.strokes:
        piece = whole(stroke)
        points = np.stack([piece.x, piece.y], axis=1)
        errors.append(_distance(points, path))
    rank = float(spearmanr(widths, forces).statistic)
    off_mm = max(map(max, errors))
    print(f"{len(painter.strokes)} strokes: width to force {rank:.3f}, off {off_mm:.2f} mm")
    assert len(painter.strokes) >= 5
    assert rank >= 0.95
    assert off_mm < 3.0


def _distance(points: NDArray[np.float64], path: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of each point from a path of short straight segments."""
    begins, ways = path[:-1], np.diff(path, axis=0)
    length = np.maximum((ways**2).sum(axis=1), 1e-9)
    t = ((points[:, None] - begins) * ways).sum(axis=2) / length
    foot = begins + t.clip(0, 1)[..., None] * ways
    return np.hypot(*(points[:, None] - foot).transpose(2, 0, 1)).min(axis=1)


@pytest.mark.slow
def test_painting_adds_little_error_to_the_sensing(
    sensed: Callable[[str, float], Any],
) -> None:
    """The brush adds at most 3 mm to the service's own error."""
    session = sensed(f"sim:painting?seed=3&mode=NFOV_2X2BINNED&{KIND_URL}", 8.0)
    frames = list(halo_client.frames(FileSource(session.stream, paced=False)))
    surface = session.truth[-1]["surface"]
    true = {}
    for line in session.truth:
        for finger in line.get("fingers", []):
            if finger["touching"]:
                place = surface.from_camera(np.array([finger["camera_mm"]]))[0]
                true[line["time_us"]] = (*place[:2], finger["force_g"])
    pairs = [
        (pointer.x_mm, pointer.y_mm, pointer.pressure, *true[frame.time_us])
        for frame in frames
        for pointer in frame.pointers
        if pointer.touching and frame.time_us in true
    ]
    sensed_frames = np.array(pairs)
    strokes = painted(frames, Painter())
    path, real = sensed_frames[:, :2], sensed_frames[:, 3:5]
    points = [np.stack([whole(stroke).x, whole(stroke).y], axis=1) for stroke in strokes]
    added = max(float(_distance(each, path).max()) for each in points)
    off = np.concatenate([_distance(each, real) for each in points])
    rank = float(spearmanr(sensed_frames[:, 2], sensed_frames[:, 5]).statistic)
    # The width at each sensed point is that of the nearest point of the curve.
    curve = np.concatenate(points)
    radius = np.concatenate([whole(stroke).radius for stroke in strokes])
    apart = np.hypot(*(path[:, None] - curve).transpose(2, 0, 1))
    widths = radius[apart.argmin(axis=1)]
    to_force, to_pressure = (
        float(spearmanr(widths, sensed_frames[:, n]).statistic) for n in (5, 2)
    )
    print(f"{len(strokes)} strokes; sensed pressure to true force {rank:.2f}")
    print(f"width to true force {to_force:.2f}, to sensed pressure {to_pressure:.2f}")
    print(f"painted off the true path: median {np.median(off):.1f}, most {off.max():.1f} mm")
    print(f"painted off the sensed path: at most {added:.1f} mm")
    whole_picture, inked = similarity(
        to_pixels(strokes, *SIZE, width_px=1200), rasterised(to_svg(strokes, *SIZE), 1200)
    )
    print(f"SVG to PNG {whole_picture:.3f}, painted parts {inked:.3f}")
    assert len(strokes) >= 2
    assert added < 3.0
    assert whole_picture >= 0.9
