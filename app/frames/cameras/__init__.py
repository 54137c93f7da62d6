"""What a run knows of the cameras of a recording: intrinsics, and how colour lies to depth."""
