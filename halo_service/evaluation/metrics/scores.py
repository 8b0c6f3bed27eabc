"""All that one take of one person says of one method."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from halo_service.evaluation.metrics.behaviour import Conduct, score_conduct
from halo_service.evaluation.metrics.confidence import Sureness, score_sureness
from halo_service.evaluation.metrics.difficult import Awkward, score_awkward
from halo_service.evaluation.metrics.keystrokes import Keys, Phrase, score_keys, score_phrases
from halo_service.evaluation.metrics.levels import Jump, Trial, score_levels, score_seam
from halo_service.evaluation.metrics.retaps import Retap, score_threshold
from halo_service.evaluation.metrics.speeds import Speed, score_strikes, score_velocity
from halo_service.evaluation.metrics.timing import Timing, score_timing
from halo_service.evaluation.metrics.touches import Touches, score_touches
from halo_service.evaluation.metrics.truth import Line, read_truth
from halo_service.geometry.surface import Surface
from halo_service.values import TouchFrame


@dataclass(frozen=True, slots=True)
class Scores:
    """Everything that could be judged; empty where a take gave no occasion."""

    touches: Touches
    sureness: Sureness
    timing: tuple[Timing, ...]
    strikes: tuple[Speed, ...]
    velocities: tuple[Speed, ...]
    conduct: Conduct
    trials: tuple[Trial, ...]
    jumps: tuple[Jump, ...]
    retaps: tuple[Retap, ...]
    awkward: tuple[Awkward, ...]
    keys: Keys
    phrases: tuple[Phrase, ...]


def score(
    frames: Sequence[TouchFrame], truth: Sequence[Line], script: Sequence[Line], surface: Surface
) -> Scores:
    """Judge published frames against the lines of truth and script of the same take.

    `surface`: the profile's; what the truth tells in the camera's frame is laid into its.
    """
    true = read_truth(truth, surface)
    touches = score_touches(frames, true)
    return Scores(
        touches,
        score_sureness(touches),
        score_timing(touches.hits),
        score_strikes(touches.hits),
        score_velocity(frames, true),
        score_conduct(frames, true, touches, surface),
        score_levels(frames, true, script),
        score_seam(frames, true),
        score_threshold(touches, true, script),
        score_awkward(touches, true, script),
        score_keys(touches),
        score_phrases(touches),
    )
