"""How good the sensing is: the paper's study on virtual people, judged against the truth.

Rule: what is measured here is never within reach of what is measured.
"""
