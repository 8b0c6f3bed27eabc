"""Cameras that are plugged in: which they are, what each lacks, and who may open them."""
