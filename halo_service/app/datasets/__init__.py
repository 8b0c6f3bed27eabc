"""Public data sets of real touches and forces, turned into our recordings and truth.

Written from their published formats and tested on small files made in those formats. The real files
were never run: they are large, and a person has to download them under their licences.
"""
