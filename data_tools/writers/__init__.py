"""Writers: a recording and its truth in one dataset layout each."""
