"""All scores of one method for one recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from halo_service.evaluation.metrics.behaviour import Behaviour, score_behaviour
from halo_service.evaluation.metrics.confidence import Confidence, score_confidence
from halo_service.evaluation.metrics.difficult import DifficultTouch, score_difficult
from halo_service.evaluation.metrics.keystrokes import Keys, Phrase, score_keys, score_phrases
from halo_service.evaluation.metrics.levels import Jump, Trial, score_jumps, score_levels
from halo_service.evaluation.metrics.retaps import Retap, score_retaps
from halo_service.evaluation.metrics.speeds import Speed, score_strikes, score_velocity
from halo_service.evaluation.metrics.timing import Timing, score_timing
from halo_service.evaluation.metrics.touches import Touches, score_touches
from halo_service.evaluation.metrics.truth import Line, read_truth
from halo_service.geometry.surface import Surface
from halo_service.values import TouchFrame


@dataclass(frozen=True, slots=True)
class Scores:
    """Everything that is measured; empty where a recording gives no occasion."""

    touches: Touches = field(default_factory=Touches)
    confidence: Confidence = field(default_factory=Confidence)
    timing: tuple[Timing, ...] = ()
    strikes: tuple[Speed, ...] = ()
    velocities: tuple[Speed, ...] = ()
    behaviour: Behaviour = field(default_factory=Behaviour)
    trials: tuple[Trial, ...] = ()
    jumps: tuple[Jump, ...] = ()
    retaps: tuple[Retap, ...] = ()
    difficult: tuple[DifficultTouch, ...] = ()
    keys: Keys = field(default_factory=Keys)
    phrases: tuple[Phrase, ...] = ()


def score(
    frames: Sequence[TouchFrame], truth: Sequence[Line], script: Sequence[Line], surface: Surface
) -> Scores:
    """Compare published frames with the lines of truth and script of the same recording.

    `surface`: the profile's; the truth's points are converted to its frame.
    """
    true = read_truth(truth, surface)
    touches = score_touches(frames, true)
    return Scores(
        touches,
        score_confidence(touches),
        score_timing(touches.hits),
        score_strikes(touches.hits),
        score_velocity(frames, true),
        score_behaviour(frames, true, touches, surface),
        score_levels(frames, true, script),
        score_jumps(frames, true),
        score_retaps(touches, true, script),
        score_difficult(touches, true, script),
        score_keys(touches),
        score_phrases(touches),
    )
