"""Folders by URI, through fsspec: staged on this machine, and published to a store that knows no rename."""
