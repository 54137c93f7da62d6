"""Poses from elsewhere: files of other programs, their kind told by content, matched with the frames of a recording."""
