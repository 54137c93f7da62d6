"""Terminal output: results, messages, progress."""
