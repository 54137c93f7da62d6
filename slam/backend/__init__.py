"""Between keyframes: pose graph, loop closure, submaps."""
