"""Image-text embeddings: CLIP, SigLIP and their kin."""
