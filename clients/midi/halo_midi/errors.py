"""What goes wrong with MIDI ports and sound files. The message is for the user."""


class MidiError(Exception):
    """A port cannot be opened, or a file cannot be rendered."""
