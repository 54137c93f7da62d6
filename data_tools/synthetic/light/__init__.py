"""Light baked into a world: what falls on each face from the sky, from lamps and from all that reflects it."""
