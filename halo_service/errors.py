"""What goes wrong in the user's hands, said in one sentence with the remedy."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

NEAR = 0.62
"""How alike two words are, from 0 to 1, for the one to be proposed for the other (chosen)."""
MOST_BEGUN = 3
"""So many words that begin alike are all proposed."""


def suggestion(word: str, known: Iterable[str]) -> str:
    """Return `did you mean '...'?` with the words that begin so, else the nearest, or nothing."""
    known = tuple(known)
    begun = [f"'{each}'" for each in known if word and each.startswith(word)]
    if 2 <= len(begun) <= MOST_BEGUN:
        return f"did you mean {' or '.join(begun)}?"
    near = difflib.get_close_matches(word, known, n=1, cutoff=NEAR)
    return f"did you mean '{near[0]}'?" if near else ""


class UserError(Exception):
    """Something the user can mend: one sentence that says what is wrong and what to do.

    The `halo` command prints it on stderr and exits with 2; it is caught nowhere else, except a
    live loop that goes on (a camera that was unplugged).
    """


class SourceLost(UserError):  # noqa: N818 - what happened, as the log says it
    """The camera went away while it was running. Worth opening it anew after a while."""
