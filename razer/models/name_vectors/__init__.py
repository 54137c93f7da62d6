"""Text embeddings of class names, which make closed-set segmenters queryable by text."""
