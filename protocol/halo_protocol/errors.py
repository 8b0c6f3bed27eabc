"""The one door by which everything malformed leaves."""


class ProtocolError(ValueError):
    """These bytes, this name or this value are not the halo protocol.

    The message says what was expected and what was found. Readers count it, log it once a
    sender, and go on; nothing else is ever raised by reading bytes.
    """
