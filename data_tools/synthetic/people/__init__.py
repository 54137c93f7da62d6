"""People who walk through a synthetic world: their shapes, their ways, and how they are filmed."""
