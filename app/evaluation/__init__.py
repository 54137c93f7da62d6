"""Maps and other systems' predictions beside the truth: `eval`, `reproduce`, `ablate`."""
