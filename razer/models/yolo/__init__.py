"""YOLO segmentation models in ONNX format."""
