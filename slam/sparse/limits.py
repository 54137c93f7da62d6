"""How many pictures can be matched all at once, and when following the camera has failed."""

MAX_PICTURES = 1500  # some 0.25 MB each, and a second of time
# Of so many pictures at most, located to no greater share by following the camera, all are matched with each other.
SHORT, FEW_LOCATED = 300, 0.75


def has_failed(n_lost: int, n_frames: int) -> bool:
    """Whether following the camera through a short recording came to little; frames that cannot be read are none that
    it lost."""
    return 1 < n_frames <= SHORT and n_lost > (1 - FEW_LOCATED) * n_frames
