"""One scene and many scenes evaluated by a preset's rules."""
