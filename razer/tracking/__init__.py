"""Multi-object tracking: association, track update, embedding banks, fusion of duplicates, pruning."""
