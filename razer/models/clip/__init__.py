"""Image-text embeddings: CLIP, SigLIP and similar models."""
