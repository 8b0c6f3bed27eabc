"""Prints the figures, and judges them."""

from __future__ import annotations

from .client import Seen
from .figures import Figures, duration

GROWTH = 0.02
"""Of memory, after warm-up."""


def result(figures: Figures, seen: Seen, log: str) -> int:
    """Print what was seen; return the exit code. `log`: of the service."""
    # The error of the fault "tracker dies" is logged once; the loop goes on.
    errors = log.count("Traceback (most") - log.count("\nRuntimeError: the model is broken")
    before_mb, after_mb = figures.memory_mb
    growth = after_mb / before_mb - 1.0
    _print_faults(figures)
    print(f"frames {seen.frames}, gaps {seen.gaps}, longest gap {seen.longest_gap_s:.2f} s")
    print(f"touches {seen.downs}, lost {figures.lost}, pointers stuck {len(seen.stuck)}")
    if errors:
        print(log[log.find("Traceback (most") :])
    print(f"errors that left the live loop {errors}, restarts {figures.restarts}")
    print(f"memory {before_mb:.1f} -> {after_mb:.1f} MB ({100 * growth:+.1f} %)")
    print(f"open files {figures.handles[0]} -> {figures.handles[1]}")
    all_in_time = all(row.good for row in figures.rows)
    good = all_in_time and not (seen.stuck or errors or growth > GROWTH) and figures.ended_empty
    print("passed" if good else "failed")
    return 0 if good else 1


def _print_faults(figures: Figures) -> None:
    print(f"{'fault':24} {'times':>5} {'reported after':>15} {'touch again after':>18}")
    for name in dict.fromkeys(row.fault for row in figures.rows):
        rows = [row for row in figures.rows if row.fault == name]
        reported = duration(_worst([row.reported_s for row in rows]))
        back = duration(_worst([row.back_s for row in rows]))
        print(f"{name:24} {len(rows):5} {reported:>15} {back:>18}")


def _worst(values: list[float | None]) -> float | None:
    times = [value for value in values if value is not None]
    return max(times) if len(times) == len(values) else None
