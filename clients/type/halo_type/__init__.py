"""A keyboard on a table: phrases, text, and how well it was typed.

Rule: a pure core (`layout`, `typist`, `metrics`, `results`) and thin input and
output (`sounds`, `view`, `app`). It imports `halo_client` and `halo_protocol`, never the service;
`layout`, `metrics` and `phrases` import neither, so the evaluation can use them.
"""

import os

# Otherwise pygame prints a greeting to stdout.
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
