"""Virtual typing, sensed by the service: the phrases, with the evaluation's keystroke errors."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import halo_client
from halo_client import FileSource
from halo_service.evaluation.metrics.keystrokes import score_keys, score_phrases
from halo_service.evaluation.metrics.touches import score_touches
from halo_service.evaluation.metrics.truth import read_truth
from halo_type.layout import load_layout
from halo_type.phrases import PHRASES, in_order_of_seed
from halo_type.typist import Trial, Typist

SEED, SECONDS, PAUSE_S = 3, 18.0, 1.6


@pytest.mark.long
def test_virtual_typing_gives_the_phrase_with_the_errors_of_the_evaluation(
    sensed: Callable[[str, float], Any],
) -> None:
    session = sensed(f"sim:typing?seed={SEED}", SECONDS)
    phrase = in_order_of_seed(PHRASES, SEED)[0]
    trials = [Trial("balanced", 1, phrase), Trial("balanced", 2, "")]
    typist = Typist(load_layout("qwerty"), trials, pause_s=PAUSE_S)
    for frame in halo_client.frames(FileSource(Path(session.stream), paced=False)):
        typist.process(frame)
    result = typist.results[0]
    touches = score_touches(
        session.frames, read_truth(session.truth[:-1], session.truth[-1]["surface"])
    )
    bench, keys = score_phrases(touches)[0], score_keys(touches)
    print(f"{result.transcribed!r} of {phrase!r}; {keys}")
    assert bench.presented == phrase
    counts = [(t.correct, t.uncorrected, t.corrected) for t in (result.typed, bench.typed)]
    assert counts[0] == counts[1]
    assert result.typed.wpm == pytest.approx(bench.typed.wpm, rel=0.02)
    assert keys.struck >= 20
    assert result.typed.uncorrected <= keys.wrong + keys.missed + keys.doubled + 1
    assert result.typed.accuracy > 0.9
