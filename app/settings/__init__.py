"""Settings of a run: their model, the file and the command line they come from."""
