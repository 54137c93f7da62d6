"""Things that stand in synthetic rooms."""
