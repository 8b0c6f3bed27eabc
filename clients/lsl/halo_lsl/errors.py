"""What goes wrong with LSL. The message is for the user."""


class LslError(Exception):
    """The library of LSL cannot be loaded, or a stream cannot be created."""
