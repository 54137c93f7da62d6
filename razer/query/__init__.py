"""Open-vocabulary queries: instances ranked by text or by image."""
