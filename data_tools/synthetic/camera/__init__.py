"""A hand-held RGB-D camera: the ways it goes, and the errors of its sensor."""
