"""The test pattern: a pointer that draws a circle, for checking connections."""
