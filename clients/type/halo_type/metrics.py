"""How well somebody typed: speed and errors of one phrase, after the definitions in use.

Rule: pure. A phrase's typing is a transcription sequence: after each entry, the time and the whole
text so far (Zhang and Wobbrock 2019). Comparing neighbours shows what was erased, by any
means; so a keyboard with a delete key needs no code of its own here.

C, INF and IF are MacKenzie and Soukoreff's (2003): characters right, wrong and left in, and erased
again. With the minimum string distance MSD(P, T) of the presented and the transcribed text,
C = max(|P|, |T|) - MSD and INF = MSD.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

CHARACTERS_A_WORD = 5
"""What "a word" of words per minute is, by convention, spaces counted."""


@dataclass(frozen=True, slots=True)
class Entry:
    """The text after one entry."""

    time_s: float
    text: str


@dataclass(frozen=True, slots=True)
class Typed:
    """How one phrase was typed."""

    wpm: float
    """Words per minute, from the first entry to the last; 0 where no time passed."""
    correct: int
    """C."""
    uncorrected: int
    """INF: wrong characters left in the text, missing ones included."""
    corrected: int
    """IF: characters that were erased again."""

    @property
    def uncorrected_rate(self) -> float:
        """INF / (C + INF + IF)."""
        return self._share(self.uncorrected)

    @property
    def corrected_rate(self) -> float:
        """IF / (C + INF + IF)."""
        return self._share(self.corrected)

    @property
    def msd_rate(self) -> float:
        """MSD / max(|P|, |T|): errors left in the text, whatever was erased on the way."""
        left = self.correct + self.uncorrected
        return self.uncorrected / left if left else 0.0

    @property
    def accuracy(self) -> float:
        """Share of the text that is right: 1 - `msd_rate`."""
        return 1.0 - self.msd_rate

    @property
    def awpm(self) -> float:
        """Speed times accuracy."""
        return self.wpm * self.accuracy

    def _share(self, count: int) -> float:
        whole = self.correct + self.uncorrected + self.corrected
        return count / whole if whole else 0.0


def typed(presented: str, entries: Sequence[Entry]) -> Typed:
    """Judge one phrase; `entries` in order of time, empty if nothing was typed."""
    transcribed = entries[-1].text if entries else ""
    wrong = distance(presented, transcribed)
    texts = ["", *(entry.text for entry in entries)]
    return Typed(
        words_per_minute(entries),
        max(len(presented), len(transcribed)) - wrong,
        wrong,
        sum(erased(before, after) for before, after in pairwise(texts)),
    )


def words_per_minute(entries: Sequence[Entry]) -> float:
    """(|T| - 1) / seconds x 60 / 5: the time of the first character is unknown."""
    seconds = entries[-1].time_s - entries[0].time_s if entries else 0.0
    if seconds <= 0.0 or not entries[-1].text:
        return 0.0
    return (len(entries[-1].text) - 1) / seconds * 60.0 / CHARACTERS_A_WORD


def distance(presented: str, transcribed: str) -> int:
    """Minimum string distance: fewest insertions, deletions and substitutions between the two."""
    row = list(range(len(transcribed) + 1))
    for i, expected in enumerate(presented, 1):
        diagonal, row[0] = row[0], i
        for j, got in enumerate(transcribed, 1):
            diagonal, row[j] = row[j], min(row[j] + 1, row[j - 1] + 1, diagonal + (expected != got))
    return row[-1]


def erased(before: str, after: str) -> int:
    """How many characters of the earlier text the later one no longer has.

    The common beginning and the common end stay; the text between was replaced.
    """
    most = min(len(before), len(after))
    begin = next((k for k in range(most) if before[k] != after[k]), most)
    rest = most - begin
    end = next((k for k in range(rest) if before[-1 - k] != after[-1 - k]), rest)
    return len(before) - begin - end
