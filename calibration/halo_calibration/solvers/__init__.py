"""Pure: arrays in, values out. What cannot be used is refused (`Refused`) with the remedy."""
