"""What goes wrong with a window."""


class StageError(Exception):
    """There is no display. The message is for the user."""
