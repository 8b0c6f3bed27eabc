"""Several virtual cameras over one table: where they are, when they expose, how they interfere."""
