"""Map while a program supplies frames one by one, such as from a camera, and look at the map on the way."""

import sys

import razer
from data_tools import open_sequence
from slam import SlamSystem

camera = open_sequence(sys.argv[1])  # stands for your camera: rgb uint8, depth in metres, intrinsics
slam = SlamSystem()
config = razer.MapperConfig.model_validate({"reintegration": {"enabled": True}})  # the map follows corrected poses
mapper = razer.Mapper(config, "geometric", "appearance")
for image in camera:
    frame = razer.Frame(image.index, image.stamp, image.rgb, image.depth, image.intrinsics)
    world_from_camera = slam.locate(frame)
    if corrections := slam.corrections():
        mapper.move(corrections)
    if world_from_camera is None:
        continue
    step = mapper.step(frame.at(world_from_camera))
    if step.born:
        print(f"frame {frame.index}: {len(mapper.tracks)} tracks, new: {step.born}")
slam.finish()
mapper.move(slam.corrections())
print(len(mapper.finish().objects), "things")
