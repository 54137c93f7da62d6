"""Open-vocabulary queries and classification of a finished run."""
