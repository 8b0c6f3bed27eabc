"""The halo's curves, on their own and on frames."""

import numpy as np
import pytest

from halo_service.values import Finger, Side
from halo_service.virtual import halo, statements
from halo_service.virtual.dents import dents_of
from halo_service.virtual.halo import FAMILIES, Dent, HaloCurve, dent_field, depth
from halo_service.virtual.hand import pointing, resting
from halo_service.virtual.room import Room
from halo_service.virtual.skeleton import FingerPose, posed
from halo_service.virtual.statements import STATEMENTS
from tests.kind_sensor import KIND_ROOM

FULL = (1.0, 1.0, 1.0)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("onset", [19.0, 22.0])
def test_every_family_grows_from_nothing_at_the_onset_to_contact(family, onset):
    curve = HaloCurve(family=family, onset_mm=onset)
    depths = [depth(curve, h) for h in np.linspace(onset + 5.0, 0.0, 100)]
    assert depths[0] == pytest.approx(0.0, abs=1e-9)
    assert np.diff(depths).min() >= 0.0
    assert depths[-1] == pytest.approx(halo.APPROACH_MM + halo.CONTACT_MM)


def test_families_differ_in_between():
    at_10 = [depth(HaloCurve(family=family), 10.0) for family in FAMILIES]
    assert len(FAMILIES) >= 3
    assert max(at_10) - min(at_10) > 1.5


def test_a_press_goes_on_growing_and_each_part_fades_alone():
    curve = HaloCurve()
    depths = [depth(curve, 0.0, force) for force in (0, 25, 100, 200, 385)]
    assert np.diff(depths).min() > 0.5
    assert depth(curve, 0.0, 385, (1, 1, 0)) == pytest.approx(depths[0])
    assert depth(curve, 0.0, 385, (0, 1, 1)) == pytest.approx(depths[-1] - halo.APPROACH_MM)


def test_dents_melt_into_more_than_one_and_less_than_their_sum():
    x, y = np.meshgrid(np.arange(-30, 31, dtype=np.float32), np.arange(-30, 31, dtype=np.float32))
    one = dent_field([Dent(0, 0, 10.0, 11.0)], x, y)
    two = dent_field([Dent(0, 0, 10.0, 11.0), Dent(4, 0, 8.0, 11.0)], x, y)
    assert one[30, 30] == pytest.approx(10.0, rel=1e-5)
    assert 10.0 < two[30, 32] < 18.0
    assert one[0, 0] < 0.01
    assert (two >= one - 1e-5).all()


def test_only_what_hangs_low_dents_the_table():
    room = Room()
    high = posed(room.user, pointing(room.user, Side.RIGHT, FingerPose(150, 100, 40)))
    assert dents_of(room, high, FULL) == []
    low = posed(room.user, pointing(room.user, Side.RIGHT, FingerPose(150, 100, 2)))
    dents = dents_of(room, low, FULL)
    deepest = max(dents, key=lambda d: d.depth_mm)
    assert (deepest.x_mm, deepest.y_mm) == pytest.approx(tuple(low.pad(Finger.INDEX)[:2]))


def test_a_resting_palm_dents_the_table_too():
    room = Room()
    hand = posed(room.user, resting(room.user, Side.RIGHT, 150, 100, 0))
    assert len(dents_of(room, hand, FULL)) > 10


@pytest.fixture(scope="module")
def _kind_reference():
    """The curves were scaled on the kind sensor: docs/virtual-kinect-facts.md has the true one."""
    before = statements.REFERENCE
    statements.REFERENCE = Room(seed=1, **KIND_ROOM)
    yield
    statements.REFERENCE = before


@pytest.mark.usefixtures("_kind_reference")
@pytest.mark.parametrize("statement", STATEMENTS, ids=lambda s: s.says)
def test_the_frames_do_what_the_paper_says(statement):
    value = statement.measure()
    print(f"{statement.says}: {value:.3g} {statement.unit}")
    assert statement.least <= value <= statement.most
