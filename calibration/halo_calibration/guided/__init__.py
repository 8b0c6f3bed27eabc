"""A person is prompted, sees the signal live, and may try again."""
