"""What goes wrong with sound devices. The message is for the user."""


class SoundError(Exception):
    """The sound device cannot be opened."""
