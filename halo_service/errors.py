"""What goes wrong in the user's hands, said in one sentence with the remedy."""


class UserError(Exception):
    """Something the user can mend: one sentence that says what is wrong and what to do.

    The `halo` command prints it on stderr and exits with 2; nobody else catches it, except a
    live loop that goes on (a camera that was unplugged).
    """


class SourceLost(UserError):  # noqa: N818 - what happened, as the log says it
    """The camera went away while it was running. Worth opening it anew after a while."""
