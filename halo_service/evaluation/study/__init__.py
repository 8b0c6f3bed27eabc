"""The study on virtual people: the plan, the cached recordings, and the run over all methods."""
