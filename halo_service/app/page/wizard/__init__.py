"""The set-up wizard: the steps of `halo calibrate` with the page as their face."""
