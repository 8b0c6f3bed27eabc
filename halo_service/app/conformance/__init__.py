"""Sends a scripted stream to a client, and compares what the client shows with what is correct."""
