"""`halo first-light`: what works on this table, in a session that follows the hand.

plan: what is done; pace: when it is done; session: does it and records; announce: prompts that are
seen and heard; report: the two pages; run: the whole way.
"""
