"""Surface metrics: accuracy, completeness, chamfer distance, F-score, and label transfer between meshes."""
