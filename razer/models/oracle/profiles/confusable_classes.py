"""Classes that detectors take for one another, and what a thing is called from each side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from razer.models.oracle.profiles.visible_things import NAMED, SECTORS, VisibleThings

CONFUSABLE = (
    ("chair", "armchair", "couch", "stool", "office chair", "bench", "ottoman"),
    ("table", "desk", "counter", "dining table", "coffee table", "end table"),
    ("cabinet", "dresser", "wardrobe", "refrigerator", "nightstand", "file cabinet", "kitchen cabinet", "tv stand",
     "mini fridge", "bookshelf", "shelf"),
    ("tv", "monitor", "picture", "window", "poster", "mirror", "whiteboard", "blackboard", "bulletin board", "laptop",
     "sign"),
    ("cup", "bowl", "vase", "bottle", "water bottle", "candle", "plate", "tray", "coffee kettle"),
    ("bed", "mattress"),
    ("pillow", "cushion", "stuffed animal", "ball"),
    ("blanket", "towel", "clothes", "mat"),
    ("curtain", "shower curtain", "blinds"),
    ("stove", "oven", "microwave", "dishwasher", "washing machine", "clothes dryer", "toaster", "coffee maker",
     "range hood"),
    ("sink", "toilet", "bathtub", "shower"),
    ("toilet paper", "paper towel roll", "tissue box", "paper", "book"),
    ("keyboard", "mouse", "telephone", "alarm clock", "clock", "headphones"),
    ("computer tower", "printer", "speaker", "radiator", "fan"),
    ("lamp", "coat rack", "column", "ladder", "guitar", "fire extinguisher"),
    ("door", "doorframe"),
    ("plant", "potted plant"),
    ("backpack", "bag", "paper bag", "purse", "suitcase"),
    ("box", "storage bin", "crate", "trash can", "recycling bin", "bucket", "basket", "laundry basket", "cart",
     "dish rack"),
)  # fmt: skip
GROUP_OF = {name: group for group in CONFUSABLE for name in group}
FLIPPED_SECTORS = SECTORS // 2


@dataclass(frozen=True, slots=True)
class Confusion:
    """How often things are called by another class of their group.

    Args:
        things: share of the things that are, at all.
        there: in which share of the frames from half of their viewing sectors.
        elsewhere: and from the other half.
    """

    things: float = 0.2
    there: float = 1.0
    elsewhere: float = 0.0


SECTOR_FLIPS = Confusion()
# Set by what `razer bench --masks` says of small models on a real kitchen (docs/evaluation.md).
UNSURE = Confusion(0.35, 0.7, 0.15)


def said_class(things: VisibleThings, thing: int, seed: int, confusion: Confusion) -> str:
    """What a detector says of a thing from where it is seen. The other class, and the sectors in which it is said, are
    a function of the seed and the thing."""
    name = things.name(thing)
    rng = np.random.default_rng([seed, NAMED, thing])
    others = [other for other in GROUP_OF.get(name, ()) if other != name]
    if rng.random() >= confusion.things or not others:
        return name
    other = others[rng.integers(len(others))]
    sectors = rng.permutation(SECTORS)[:FLIPPED_SECTORS]
    is_there = things.sector(thing, rng.uniform(0, 360 / SECTORS)) in sectors
    in_frame = np.random.default_rng([seed, NAMED, thing, things.frame.index]).random()
    return other if in_frame < (confusion.there if is_there else confusion.elsewhere) else name
