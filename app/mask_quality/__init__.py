"""How good the masks of a segmenter are: from view to view, and beside what is true."""
