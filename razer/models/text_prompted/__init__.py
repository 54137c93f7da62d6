"""Open-vocabulary segmentation from text prompts."""
