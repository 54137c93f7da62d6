"""Instance segmentation by YOLO models in ONNX format."""
