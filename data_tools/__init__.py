"""Where frames come from: readers, writers and synthetic rooms."""
