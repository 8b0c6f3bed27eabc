"""The loop that brings frames to the sensing and touch frames to the outputs.

Rule: the runtime receives its parts from the app. Threads exchange values through `Latest` alone.
"""
