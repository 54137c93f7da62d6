"""Image-text models: CLIP, SigLIP and their kin."""
