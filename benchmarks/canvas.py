"""How well a canvas merges nodes at their seams: `uv run python benchmarks/canvas.py`.

Fingers cross the seams of surfaces in a row, 500 crossings: slides, hovers, quick taps on the seam,
two fingers side by side, slides to and fro. Simulated nodes report them as datagrams with the
errors that `merging/nodes.py` lists. The figures are those of the goals of `halo canvas`.
"""

from __future__ import annotations

import argparse
import sys

from merging.run import simulated
from merging.score import Score


def main() -> int:
    """Print the figures; 1 if a goal is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--crossings", type=int, default=500)
    parser.add_argument("--nodes", type=int, default=2, help="surfaces in a row")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--wrong", action="store_true", help="list what went wrong")
    options = parser.parse_args()
    result = simulated(options.nodes, options.crossings, options.seed)
    return int(not shown(result, wrong=options.wrong))


def shown(result: Score, *, wrong: bool) -> bool:
    """Print the figures; return whether all goals are met."""
    for name, figure, goal, met in result.rows():
        verdict = "" if not goal else f"{goal:12}{'ok' if met else 'failed'}"
        print(f"{name:32}{figure:>12}   {verdict}".rstrip())
    if wrong:
        print(*result.wrong, sep="\n")
    return all(met for *_, met in result.rows())


if __name__ == "__main__":
    sys.exit(main())
