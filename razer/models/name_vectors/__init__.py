"""Class names embedded as text: closed-set detectors, asked in words."""
