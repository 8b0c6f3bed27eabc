"""The cases behind `vectors/*.json`: what to say, and what comes of it.

Rule: pure tables. A new case is a new entry; `generate.py` next to this folder writes the files,
and what is expected is computed by the code, so a change of behaviour shows as a change of files.
"""
