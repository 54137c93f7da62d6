"""The program: verbs, main loop, run folder, timeline."""
