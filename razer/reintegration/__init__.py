"""The map follows corrected poses: kept frames are integrated anew."""
