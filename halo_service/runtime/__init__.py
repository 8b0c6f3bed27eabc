"""The loop that brings frames to the sensing and touches to the outputs.

Rule: the runtime is handed its parts. Threads hand over to each other by one thing, `Latest`.
"""
