"""Stage 8: a touch counts once between two verified no-touches (paper 4.3.6, typing)."""

from __future__ import annotations

from dataclasses import dataclass

from halo_service.values import Contact

NO_TOUCH = Contact(touching=False, count=0, ago_us=0)


@dataclass(frozen=True, slots=True)
class Debounce:
    """One finger's debounce between two frames."""

    contact: Contact = NO_TOUCH
    ended_us: int | None = None
    """Since when a touch has ended in one frame that no second frame has confirmed yet."""


def debounce(before: Debounce, touching: bool, ago_us: int, time_us: int) -> Debounce:
    """Advance by one frame: down counts at once, up when a second frame agrees."""
    contact = before.contact
    if not contact.touching:
        if touching:
            return Debounce(Contact(True, contact.count + 1, ago_us))
        return Debounce(Contact(False, contact.count, 0))
    if touching:
        return Debounce(Contact(True, contact.count, 0))
    if before.ended_us is None:
        return Debounce(Contact(True, contact.count, 0), time_us - ago_us)
    return Debounce(Contact(False, contact.count, time_us - before.ended_us))
