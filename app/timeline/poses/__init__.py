"""Pose estimation on the timeline."""
