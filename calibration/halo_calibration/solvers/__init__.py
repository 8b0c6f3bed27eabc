"""Pure: arrays in, values out. A `CalibrationError` says what cannot be used, and the remedy."""
