"""The running service: a source in, touches out."""
