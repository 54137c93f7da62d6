"""The main loop, and what a run is from its first frame to its folder."""
