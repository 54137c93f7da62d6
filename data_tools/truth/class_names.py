"""Mapping of class names between vocabularies: Replica's, ScanNet's and those of NYU40."""

from __future__ import annotations

from razer.vocabulary import Category, Vocabulary, vocabulary

# ScanNet200 names and what Replica calls such things; the first of several is what Replica's name is turned into.
_REPLICA_BY_SCANNET = {
    "couch": "sofa",
    "trash can": "bin",
    "plant": "indoor-plant",
    "potted plant": "indoor-plant",
    "tv": "tv-screen",
    "bicycle": "bike",
    "clothes": "clothing",
    "keyboard": "computer-keyboard",
    "counter": "countertop",
    "computer tower": "desktop-computer",
    "purse": "handbag",
    "rail": "handrail",
    "paper towel roll": "paper-towel",
    "telephone": "phone",
    "shower": "shower-stall",
    "stairs": "stair",
    "tissue box": "tissue-paper",
    "power outlet": "wall-plug",
    "light switch": "switch",
    "stove": "cooktop",
    "kitchen cabinet": "base-cabinet",
    "ball": "exercise-ball",
    "office chair": "chair",
    "armchair": "chair",
    "coffee table": "table",
    "dining table": "table",
    "end table": "table",
    "bookshelf": "shelf",
}
_SCANNET_BY_REPLICA = {replica: scannet for scannet, replica in reversed(_REPLICA_BY_SCANNET.items())}


def category_of(name: str, classes: Vocabulary) -> Category | None:
    """The class of a list that a name of any list means: by the name, then where the list has NYU40's numbers by the
    number that the name has, elsewhere by what ScanNet or Replica call it; None where there is none."""
    plain = name.strip().lower()
    if category := _first(_spellings(plain), classes):
        return category
    if classes.name in ("nyu40", "scannet20"):
        return classes.by_id.get(nyu40_number(plain))
    return _first(_other_names(plain), classes)


def nyu40_number(name: str) -> int:
    """The number of a class among those of NYU40, 0 where the name is in no list or belongs to none."""
    lists = [vocabulary(known) for known in ("nyu40", "scannet200", "replica")]
    matches = (_first(names(name), known) for names in (_spellings, _other_names) for known in lists)
    return next((category.nyu40 for category in matches if category), 0)


def _first(names: tuple[str, ...], classes: Vocabulary) -> Category | None:
    return next((classes.by_name[name] for name in names if name in classes.by_name), None)


def _spellings(name: str) -> tuple[str, ...]:
    return name, name.replace("-", " "), name.replace(" ", "-")


def _other_names(name: str) -> tuple[str, ...]:
    return tuple(known[name] for known in (_REPLICA_BY_SCANNET, _SCANNET_BY_REPLICA) if name in known)
