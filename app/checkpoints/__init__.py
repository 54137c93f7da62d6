"""Checkpoints of a run: all that its processes hold, written between two frames, from which a killed run goes on."""
