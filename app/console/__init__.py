"""What is printed: results, messages, progress."""
