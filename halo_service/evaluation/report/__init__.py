"""Results in words: figures, goals, breakdowns, short lines, CSV and a page of plots."""
