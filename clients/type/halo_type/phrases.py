"""Short sentences to type: lower case, letters and spaces only, written for this project."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

MOST_PHRASES, LONGEST = 10_000, 200
"""In a file of the user: more phrases or characters are a mistake."""


class PhrasesError(Exception):
    """A file of phrases cannot be used. The message is for the user."""


def in_order_of_seed(phrases: Sequence[str], seed: int) -> tuple[str, ...]:
    """Return them in an order that the seed gives; a virtual typist of that seed has the same."""
    import numpy as np  # not needed by those that only read phrases

    return tuple(phrases[n] for n in np.random.default_rng([seed, 4]).permutation(len(phrases)))


def read_phrases(path: Path, characters: Collection[str]) -> tuple[str, ...]:
    """Read a phrase from each line, in lower case. Raises `PhrasesError` with one sentence."""
    try:
        lines = path.read_text("utf-8").lower().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
        raise PhrasesError(f"cannot read {path} ({reason}); check the path") from error
    phrases = tuple(" ".join(line.split()) for line in lines if line.strip())
    if not 1 <= len(phrases) <= MOST_PHRASES:
        raise PhrasesError(
            f"{path} has {len(phrases)} phrases; write 1 to {MOST_PHRASES}, one on each line"
        )
    for phrase in phrases:
        missing = sorted(set(phrase) - set(characters))
        if missing:
            raise PhrasesError(
                f"{path}: the keyboard has no key for {missing[0]!r} in {phrase[:40]!r}; "
                "leave it out, or choose another --layout"
            )
        if len(phrase) > LONGEST:
            raise PhrasesError(f"{path}: {phrase[:40]!r}... is longer than {LONGEST} characters")
    return phrases


PHRASES = (
    "a quiet morning by the harbour",
    "the kettle sings before it boils",
    "bring a warm coat and some bread",
    "every drum has a skin and a voice",
    "we painted the fence twice in june",
    "light falls softly on wet stones",
    "the train was late but nobody minded",
    "fold the paper along the dotted line",
    "seven brown hens sat in the yard",
    "please water the plants on friday",
    "her bicycle leans against the wall",
    "an old map shows a hidden lake",
    "turn the page when the bell rings",
    "the baker opens long before dawn",
    "few people know the way up there",
    "measure twice and cut only once",
    "his jacket smells of pine and smoke",
    "the river bends around the mill",
    "you can hear the sea from here",
    "a table can be many things",
    "grey clouds gather over the valley",
    "someone left the window open again",
    "the youngest child asked the question",
    "put the blue cup next to the jug",
    "they walked home through fresh snow",
    "music makes the long road shorter",
    "this chair was built by my uncle",
    "frogs began to call after the rain",
    "keep your fingers off the hot lid",
    "a small boat crossed the wide bay",
    "the clock in the hall is slow",
    "six quick taps and then a pause",
    "we never lock the garden gate",
    "the soup needs salt and more time",
    "dust danced in the yellow light",
    "nobody expected such a clear answer",
    "the museum closes early on sunday",
    "take the second path on the left",
    "zebras and oxen drink side by side",
    "my sister plays jazz on an old piano",
    "the lighthouse keeper writes letters",
    "soft wood is easy to carve",
    "count the steps down to the cellar",
    "a fox ran quickly over the field",
    "the glass was full to the brim",
    "she draws better with her left hand",
    "wind pushed the door wide open",
    "there is honey at the back of the shelf",
    "each key should feel the same",
    "the last bus leaves before midnight",
    "warm hands make good pottery",
    "an apple fell on the tin roof",
    "he mixed red and white to get pink",
    "the bridge hums when lorries pass",
    "tie a firm knot in the thick rope",
    "our neighbours keep bees and goats",
    "the map is larger than the room",
    "ask the tall waiter for the bill",
    "leaves turn gold in late october",
    "that puzzle has five missing pieces",
)
