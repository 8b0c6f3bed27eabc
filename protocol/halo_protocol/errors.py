"""The one error of this package."""


class ProtocolError(ValueError):
    """These bytes, this name or this value are not the halo protocol.

    The message states what was expected and what was found. Readers count it, log it once per
    sender, and continue. Reading bytes raises nothing else.
    """
