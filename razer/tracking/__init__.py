"""Detections become tracks: association, update, embeddings, fusion, pruning."""
