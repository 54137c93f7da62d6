"""Instance metrics: matching, average precision, panoptic quality, top-1 retrieval."""
