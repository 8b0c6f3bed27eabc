"""What goes wrong before anything is received, said in one sentence with the remedy."""


class EndOfStream(Exception):  # noqa: N818 - an end, and no error
    """An input has nothing more to bring, ever. The receiver takes it; no caller sees it."""


class ClientError(Exception):
    """A source that cannot be understood or opened. The message is meant for the user."""
