"""A hand-held RGB-D camera: its paths, and the errors of its sensor."""
