"""Estimate where the camera was, from the images alone."""

import sys

from data_tools import open_sequence
from slam import SlamSystem

slam = SlamSystem()
for frame in open_sequence(sys.argv[1]):
    if slam.locate(frame) is None:
        print(f"frame {frame.index}: lost")
slam.finish()
for index, world_from_camera in slam.trajectory().items():
    print(index, world_from_camera[:3, 3].round(3))
