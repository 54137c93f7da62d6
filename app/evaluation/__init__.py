"""Maps and other systems' predictions beside the truth."""
