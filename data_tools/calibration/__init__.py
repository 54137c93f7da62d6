"""RGB-D calibration from the images alone: where the colour camera stands beside the depth camera."""
