"""The figures that have a goal, each of one method's results, and whether it meets the goal.

Rule: the goals stand here as numbers, once. None: the results hold nothing of that figure.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from halo_service.evaluation.metrics.behaviour import Conduct
from halo_service.evaluation.metrics.confidence import Sureness
from halo_service.evaluation.metrics.keystrokes import Keys
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.metrics.retaps import threshold_mm, told_by_lift
from halo_service.evaluation.metrics.spatial import as_the_paper, from_target, from_truth, spatial
from halo_service.evaluation.metrics.speeds import Speed, rank_correlation, relative_error
from halo_service.evaluation.metrics.timing import median_late
from halo_service.evaluation.report import select

F1, LABELLED_F1 = 0.999, 0.98
DOUBLED_OF, STUDIED = 2, 3840
"""At most so many doubled touches of so many; none missed, none outside, no ghosts."""
SPATIAL_MM = 3.0
LIFT_MM = 2.0
HOVER_MM = 1.0
PRESSURE_SHARE = 8.0
"""Percent of 385 g."""
UNSEEN = 0.01
"""Chosen: who says nothing in more of the frames has not measured the level."""
WRONG_KEYS = 0.01
FRAME_MS = 1000.0 / 30.0


@dataclass(frozen=True, slots=True)
class Measured:
    """What one method reached."""

    told: str
    meets: bool | None = None
    """The goal; None where none is set."""


Measure = Callable[[Sequence[Result]], Measured | None]


def accuracy(results: Sequence[Result]) -> Measured | None:
    """Precision, recall and F1 of target pointing."""
    told = select.touches(select.pointing(results))
    if not told.true:
        return None
    shares = told.precision, told.recall, told.f1
    return Measured(" / ".join(f"{100 * s:.2f}" for s in shares) + " %", told.f1 >= F1)


def counts(results: Sequence[Result]) -> Measured | None:
    """What went wrong in target pointing; ghosts count with what lay outside."""
    told = select.touches(select.pointing(results))
    if not told.true:
        return None
    missed, doubled, false = len(told.missed), len(told.doubled), told.false - len(told.doubled)
    few = doubled <= DOUBLED_OF * told.true // STUDIED
    words = f"{missed} / {doubled} / {false} of {told.true}"
    return Measured(words, missed == 0 and few and false == 0)


def real_taps(results: Sequence[Result]) -> Measured | None:
    """F1 of taps timed as real people tapped; beside it those too short for any frame."""
    told = select.touches(select.labelled(results))
    if not told.true:
        return None
    words = f"{100 * told.f1:.2f} % of {told.true}"
    if told.blind:
        words += f" ({told.blind_hits} of {len(told.blind)} that hold none)"
    return Measured(words, told.f1 >= LABELLED_F1)


def spatial_error(results: Sequence[Result]) -> Measured | None:
    """Distance of hits from the true place in the frame that told each.

    Where nobody knows it, from the target: with people's own scatter in it, so without a verdict.
    """
    off = spatial(from_truth(select.touches(select.pointing(results)).hits))
    if off is None:
        return None
    words = f"{off.mean_mm:.1f} ± {off.sd_mm:.1f} mm"
    if any(result.asked for result in results):
        return Measured(f"{words} from the target")
    return Measured(words, off.mean_mm <= SPATIAL_MM)


def spatial_error_as_the_paper(results: Sequence[Result]) -> Measured | None:
    """Distance from the target, reduced as the paper reduced it."""
    errors = from_target(select.touches(select.pointing(results)).hits)
    off = spatial(as_the_paper(errors))
    if off is None:
        return None
    removed = float(np.hypot(*errors.mean(axis=0)))
    return Measured(f"{off.mean_mm:.1f} mm, after {removed:.1f} mm")


def least_lift(results: Sequence[Result]) -> Measured | None:
    """The touch point threshold."""
    retaps = [
        each
        for part in select.tasks(results, "threshold", select.RECORDING)
        for each in part.retaps
    ]
    if not retaps:
        return None
    shares = told_by_lift(retaps)
    least = threshold_mm(shares)
    if least is None:
        return Measured(f"above {max(shares):g} mm", False)
    return Measured(f"{least:g} mm", least <= LIFT_MM)


def level(kind: str, noisy: bool, unit: str, most: float) -> Measure:
    """Return the measure of a held level."""

    def measure(results: Sequence[Result]) -> Measured | None:
        held = select.trials(results, kind, noisy)
        mean, sd = select.mean_error(held)
        if np.isnan(mean):
            return None
        unseen = select.unseen(held)
        words = f"{mean:.2f} ± {sd:.2f} {unit}"
        if unseen > UNSEEN:
            words += f" ({100 * unseen:.0f} % unseen)"
        return Measured(words, mean <= most and unseen <= UNSEEN)

    return measure


def worst_family(kind: str, unit: str, most: float) -> Measure:
    """Return the measure of a level for the family of halo curves that it is worst for."""

    def measure(results: Sequence[Result]) -> Measured | None:
        families = sorted({r.subject.family for r in results if r.scores and r.subject.family})
        means, unseens = {}, {}
        for family in families:
            mine = [r for r in results if r.subject.family == family]
            for noisy in (False, True):
                held = select.trials(mine, kind, noisy)
                who = f"{family}{', doubled noise' if noisy else ''}"
                mean, _ = select.mean_error(held)
                unseens[who] = select.unseen(held)
                if not np.isnan(mean):
                    means[who] = mean
        if not means:
            return None
        worst, silent = (max(each, key=each.__getitem__) for each in (means, unseens))
        mean, unseen = means[worst], unseens[silent]
        words = f"{mean:.2f} {unit} ({worst})"
        if unseen > UNSEEN:
            words += f", {100 * unseen:.0f} % unseen ({silent})"
        return Measured(words, mean <= most and unseen <= UNSEEN)

    return measure


def wrong_keys(results: Sequence[Result]) -> Measured | None:
    """Keystrokes told as another key, not at all, or twice."""
    keys = sum(
        (part.keys for part in select.tasks(results, *select.TYPING, select.RECORDING)), Keys()
    )
    if not keys.struck:
        return None
    shares = [count / keys.struck for count in (keys.wrong, keys.missed, keys.doubled)]
    words = " / ".join(f"{100 * share:.1f}" for share in shares) + f" % of {keys.struck}"
    return Measured(words, max(shares) <= WRONG_KEYS)


def awpm(results: Sequence[Result]) -> Measured | None:
    """Speed times accuracy of the balanced task (T2), and what the fingers would have given."""
    phrases = [
        p for part in select.tasks(results, "typing", select.RECORDING) for p in part.phrases
    ]
    if not phrases:
        return None
    ours = float(np.mean([phrase.typed.awpm for phrase in phrases]))
    perfect = float(np.mean([phrase.perfect.awpm for phrase in phrases]))
    return Measured(f"{ours:.1f} of {perfect:.1f}")


def contact_to_down(results: Sequence[Result]) -> Measured | None:
    """From contact to the frame that told it, on the frames' clock; 0 for one told before it."""
    timing = [each for part in select.pointing(results) for each in part.timing]
    late = median_late(timing)
    if late is None:
        return None
    median, frames = late
    p95 = float(np.percentile([each.late_ms for each in timing], 95.0))
    early = 100.0 * float(np.mean([each.early for each in timing]))
    words = (
        f"{median:.0f} ms (p95 {p95:.0f}), {frames:+g} frames, {early:.0f} % told before contact"
    )
    return Measured(words, median <= FRAME_MS)


def strike_speed(results: Sequence[Result]) -> Measured | None:
    """Approach speed before contact."""
    return _speeds([each for part in select.pointing(results) for each in part.strikes])


def velocity(results: Sequence[Result]) -> Measured | None:
    """Velocity in the plane, of moving fingers."""
    return _speeds([each for part in select.pointing(results) for each in part.velocities])


def _speeds(speeds: Sequence[Speed]) -> Measured | None:
    if not speeds:
        return None
    rank = rank_correlation(speeds)
    ranked = "-" if np.isnan(rank) else f"{rank:.2f}"
    return Measured(f"{100.0 * relative_error(speeds):.0f} % / {ranked}")


def palms(results: Sequence[Result]) -> Measured | None:
    """Downs where no finger touched, while palms and fists lay about."""
    parts = select.tasks(results, *select.HANDS)
    if not parts:
        return None
    told = select.touches(parts)
    ghosts = len(told.ghosts) + len(told.outside)
    return Measured(f"{ghosts} beside {told.true} touches", ghosts == 0)


def wrong_surely(results: Sequence[Result]) -> Measured | None:
    """Touches told wrongly where touch is hard to see; of who tells none there is no figure."""
    parts = select.hard(results)
    told = sum((part.sureness for part in parts), Sureness())
    if not told.told:
        return None
    touches = select.touches(parts)
    words = (
        f"{told.wrong_surely} / {told.wrong_unsurely} of {told.told}, "
        f"{len(touches.missed)} of {touches.true} missed"
    )
    return Measured(words, told.wrong_surely == 0)


def right_surely(results: Sequence[Result]) -> Measured | None:
    """Share of the right touches that were told surely: of target pointing, and hard to see."""
    cells = []
    for parts in (select.pointing(results), select.hard(results)):
        told = sum((part.sureness for part in parts), Sureness())
        cells.append(f"{100 * told.right_surely / told.right:.1f}" if told.right else "-")
    return None if set(cells) == {"-"} else Measured(" / ".join(cells) + " %")


def all_fingers(results: Sequence[Result]) -> Measured | None:
    """Both hands, every finger in its turn."""
    told = select.touches(select.tasks(results, "ten-fingers"))
    return Measured(f"{100 * told.f1:.1f} % of {told.true}") if told.true else None


def stuck_and_renamed(results: Sequence[Result]) -> Measured | None:
    """Touches that stick, and fingers that lose their id."""
    parts = [r.scores for r in results if r.scores]
    if not parts:
        return None
    stuck = sum(part.conduct.stuck for part in parts)
    changes = sum(part.conduct.id_changes for part in parts)
    return Measured(f"{stuck} / {changes}", stuck == 0 and changes == 0)


def without_pointer(results: Sequence[Result]) -> Measured | None:
    """Low fingers that play and had no pointer; of who tells touches alone there is no figure."""
    conduct = sum((r.scores.conduct for r in results if r.scores), Conduct())
    if not conduct.fingers or (conduct.pointers and not conduct.aloft):
        return None
    return Measured(f"{100 * conduct.unseen / conduct.fingers:.1f} %")


def not_calibrated(results: Sequence[Result]) -> Measured | None:
    """People at a table that the calibration refused."""
    people = {result.subject.name for result in results}
    refused = select.refused(results)
    return Measured(f"{len(refused)} of {len(people)}", not refused) if people else None
