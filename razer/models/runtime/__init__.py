"""Inference back ends: ONNX Runtime, torch, checkpoints of transformers."""
