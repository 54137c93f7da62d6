"""Inference back ends: ONNX Runtime, torch, checkpoints of transformers."""

import os

# ONNX Runtime's builds for Linux tell Microsoft of their use, unless this is set before its first import.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
