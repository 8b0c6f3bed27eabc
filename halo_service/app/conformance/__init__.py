"""Plays a scripted stream at a client, and compares what the client shows with what is correct."""
