"""The life of each instance on the timeline."""
