"""Several segmenters as one: things of one over stuff of another."""
