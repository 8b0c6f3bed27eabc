"""What goes wrong with sound devices and MIDI ports. Each message is for the user."""


class SoundError(Exception):
    """The sound device cannot be opened."""


class MidiError(Exception):
    """The port cannot be opened."""
