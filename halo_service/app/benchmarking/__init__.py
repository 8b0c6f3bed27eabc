"""`halo bench`: the latency on this machine."""
