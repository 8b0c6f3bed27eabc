"""What the published frames are worth: pure functions of published frames and truth."""
