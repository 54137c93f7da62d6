"""Model weights: catalogue, download from the Hugging Face Hub, cache."""
