"""Map an RGB-D folder, save the map, open it again and ask it."""

import sys

import razer
from data_tools import open_sequence

folder, out = sys.argv[1:3]
mapper = razer.Mapper(segmenter="geometric", embedder="appearance")
for frame in open_sequence(folder):
    mapper.step(frame)
result = mapper.finish()
result.save(out)

for thing in razer.load_map(out).objects:
    print(thing.id, thing.box.center.round(2), thing.box.extent.round(2), round(thing.score, 2))
