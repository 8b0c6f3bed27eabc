"""A script says which step happens when in a recording."""
