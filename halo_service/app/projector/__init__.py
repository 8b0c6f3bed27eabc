"""Pictures on the table: the projector's display, a virtual projector or a file."""
