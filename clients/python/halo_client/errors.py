"""Errors of a source: one sentence with the remedy."""


class EndOfStream(Exception):  # noqa: N818 - an end, not an error
    """An input has ended for good. The receiver handles it; no caller sees it."""


class ClientError(Exception):
    """A source is invalid or cannot be opened. The message is for the user."""
