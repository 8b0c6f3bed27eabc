"""The person at the virtual table, and what is calibrated with them."""
