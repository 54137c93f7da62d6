"""Evidence on tracks, in log-odds of views: that they exist, and that two of them are one thing."""
