"""The `halo` command: the one place that knows everybody, and imports them lazily."""
