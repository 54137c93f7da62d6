"""One run: recording in, main loop, run folder out."""
