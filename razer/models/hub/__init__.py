"""Where weights come from: catalogue, download, cache."""
