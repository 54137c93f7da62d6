"""Oriented bounding boxes: PCA fit, exact IoU, and an R-tree of them."""
