"""Semantic segmentation: a class for every pixel, by ONNX graphs and checkpoints of transformers."""
