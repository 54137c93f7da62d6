"""From frame to frame: features, ICP, tracking against a keyframe."""
