"""The folder of a run: written whole, and read back."""
