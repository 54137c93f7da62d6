"""A segmenter of your own: anything with a method segment(frame) -> Masks."""

import sys

import cv2
import numpy as np

import razer
from data_tools import open_sequence


class DarkThings:
    """Every connected dark region of the image is a mask."""

    def segment(self, frame: razer.Frame) -> razer.Masks:
        """The masks of one frame, with a score each."""
        dark = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY) < 60
        count, labels = cv2.connectedComponents(dark.astype(np.uint8))
        masks = np.array([labels == i for i in range(1, count) if (labels == i).sum() > 400], bool)
        return razer.Masks(masks.reshape(-1, *dark.shape), np.ones(len(masks), np.float32))


mapper = razer.Mapper(segmenter=DarkThings(), embedder="appearance")
for frame in open_sequence(sys.argv[1]):
    mapper.step(frame)
print(len(mapper.finish().objects), "dark things")
