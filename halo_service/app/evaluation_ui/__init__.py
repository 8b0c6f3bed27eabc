"""`halo evaluate`: run the study, or a session on a real table, and print the results."""
