"""How many pictures can be matched all at once, and when following the camera has failed."""

MAX_PICTURES = 1500  # some 0.25 MB each, and a second of time
# Of so many pictures at most, of which following the camera lost a greater share, all are matched with each other.
SHORT, MOST_LOST = 300, 0.25


def has_failed(n_lost: int, n_frames: int) -> bool:
    """Whether following the camera through a short recording came to little; frames that cannot be read are none that
    it lost."""
    return 1 < n_frames <= SHORT and n_lost > MOST_LOST * n_frames
