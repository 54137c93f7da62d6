"""What computes a model: ONNX Runtime, torch, checkpoints of transformers."""
