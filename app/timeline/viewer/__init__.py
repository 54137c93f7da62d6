"""Viewers of a timeline: Rerun's own window, and its page in a browser, each as a process of its own."""
