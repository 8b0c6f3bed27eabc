"""What the published frames are worth: pure functions of the frames and of the truth."""
