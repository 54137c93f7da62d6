"""How much of the true things and surfaces a segmenter recognises."""
