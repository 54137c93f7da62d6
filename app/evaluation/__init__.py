"""Evaluation of maps and of other systems' predictions against the ground truth."""
