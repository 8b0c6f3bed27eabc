"""What goes wrong before anything is received, said in one sentence with the remedy."""


class ClientError(Exception):
    """A source that cannot be understood or opened. The message is meant for the user."""
