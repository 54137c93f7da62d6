"""Instance segmentation by RF-DETR models in ONNX format."""
