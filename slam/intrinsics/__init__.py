"""Intrinsics from views: matched features with depth, and the camera under which they are one scene."""
