"""HaloTouch to the letter (Xia et al. 2025): signal, detector, calibration and method."""
