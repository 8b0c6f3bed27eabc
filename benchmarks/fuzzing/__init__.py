"""Random and mutated input for the service and for its clients."""
