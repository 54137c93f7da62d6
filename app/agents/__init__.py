"""Tools by which agents ask a map, and edit it where they may: the Model Context Protocol."""
