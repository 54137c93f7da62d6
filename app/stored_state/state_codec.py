"""State of objects as a tree of plain JSON and packed arrays, and back.

What pickle does, for classes that are known beforehand: a file names none of which the program did not expect, and
nothing in it is called. Of dataclasses their fields are kept, of other classes what `__getstate__` returns; both come
back without `__init__`. What is shared stays shared.
"""

from __future__ import annotations

import dataclasses
from collections import Counter, OrderedDict, defaultdict, deque
from collections.abc import Callable, Iterable, Mapping
from enum import Enum
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np
import torch

from app.stored_state.array_packs import PackReader, PackWriter, Place
from razer.errors import BadInput
from razer.settings import Settings

FACTORIES: Mapping[str, Callable[[], Any]] = {"list": list, "set": set, "int": int, "float": float}
_SEQUENCES: Mapping[str, type] = {"deque": deque, "list": list, "tuple": tuple, "set": set, "frozenset": frozenset}
_MAPPINGS: Mapping[str, type] = {"dict": dict, "counter": Counter, "ordered": OrderedDict}
_TAGS = {kind: tag for tag, kind in (*_SEQUENCES.items(), *_MAPPINGS.items())}
Tree = Any  # None, bool, int, float, str, or a list [tag, ...] of such


@dataclasses.dataclass(frozen=True)
class KnownObjects:
    """What trees may speak of besides plain values: classes, by name; objects that both sides have already, by name,
    such as settings; and classes whose objects hold nothing, each with what makes one anew."""

    classes: Mapping[str, type]
    given: Mapping[str, object]
    made: Mapping[type, Callable[[], object]]

    @classmethod
    def of(
        cls,
        classes: Iterable[type],
        settings: Settings | None = None,
        made: Mapping[type, Callable[[], object]] = MappingProxyType({}),
        **given: object,
    ) -> KnownObjects:
        """Classes by their own names, with their modules'; settings and their sections are given by theirs."""
        sections = {} if settings is None else {"settings": settings} | dict(settings)
        given |= {name: value for name, value in sections.items() if isinstance(value, Settings)}
        return cls({class_name(kind): kind for kind in (*classes, *made)}, given, made)

    def __add__(self, other: KnownObjects) -> KnownObjects:
        return KnownObjects(
            {**self.classes, **other.classes}, {**self.given, **other.given}, {**self.made, **other.made}
        )


def class_name(kind: type) -> str:
    """How a class is called in trees."""
    return f"{kind.__module__}.{kind.__qualname__}"


class Encoder:
    """Makes one tree; arrays go to a pack."""

    def __init__(self, known: KnownObjects, packs: PackWriter) -> None:
        self._known, self._packs = known, packs
        self._given = {id(value): name for name, value in known.given.items()}
        self._numbers: dict[int, int] = {}
        self._alive: list[object] = []  # so that no other object gets the id of one that was seen

    def encode(self, value: object) -> Tree:
        """The tree of a value; raises TypeError for an object of a class that is not known."""
        if value is None or type(value) in (bool, int, float, str):
            return value
        if (name := self._given.get(id(value))) is not None:
            return ["given", name]
        if (number := self._numbers.get(id(value))) is not None:
            return ["same", number]
        self._numbers[id(value)] = number = len(self._alive)
        self._alive.append(value)
        return [*self._encoded(value), number]

    def _encoded(self, value: object) -> list[Tree]:
        match value:
            case np.ndarray():
                return ["array", *self._packed(value)]
            case torch.Tensor():
                return ["tensor", *self._packed(value.detach().cpu().numpy()), str(value.device)]
            case np.generic():
                return ["scalar", *self._packed(np.asarray(value))]
            case bytes():
                return ["bytes", *dataclasses.astuple(self._packs.put(value))]
            case Enum():
                return ["enum", self._name(type(value)), value.name]
            case defaultdict():
                factory = next(name for name, kind in FACTORIES.items() if kind is value.default_factory)
                return ["default", factory, self._pairs(value)]
        if hasattr(value, "_fields"):  # a named tuple
            return ["named", self._name(type(value)), [self.encode(item) for item in value]]  # type: ignore[attr-defined]
        if (tag := _TAGS.get(type(value))) is not None:
            items: Any = value
            return [tag, self._pairs(items) if tag in _MAPPINGS else [self.encode(item) for item in items]]
        name = self._name(type(value))
        return ["made", name] if type(value) in self._known.made else ["object", name, self.encode(_state(value))]

    def _packed(self, array: np.ndarray) -> list[Tree]:
        whole = np.ascontiguousarray(array)
        place = self._packs.put(whole.reshape(-1).view(np.uint8).data)
        return [*dataclasses.astuple(place), whole.dtype.str, list(array.shape)]

    def _pairs(self, mapping: Mapping[Any, Any]) -> list[Tree]:
        return [[self.encode(key), self.encode(value)] for key, value in mapping.items()]

    def _name(self, kind: type) -> str:
        if (name := class_name(kind)) not in self._known.classes:
            raise TypeError(f"{name} is not among the classes that a checkpoint knows")
        return name


class Decoder:
    """Reads one tree."""

    def __init__(self, known: KnownObjects, packs: PackReader) -> None:
        self._known, self._packs = known, packs
        self._values: dict[int, object] = {}

    def decode(self, tree: Tree) -> Any:
        """The value of a tree; raises BadInput for one that `Encoder` did not make."""
        try:
            return self._decoded(tree)
        except BadInput:
            raise
        except (KeyError, IndexError, TypeError, ValueError, AttributeError, RecursionError) as error:
            raise BadInput("the checkpoint is damaged, or of another version: the run cannot be resumed") from error

    def _decoded(self, tree: Tree) -> Any:
        if not isinstance(tree, list):
            return tree
        tag, *content = tree
        if tag == "given":
            return self._known.given[content[0]]
        if tag == "same":
            return self._values[content[0]]
        *content, number = content
        if tag == "object":
            return self._object(content[0], content[1], number)
        if tag in _MAPPINGS or tag == "default":
            kind: Any = _MAPPINGS[tag] if tag in _MAPPINGS else partial(defaultdict, FACTORIES[content[0]])
            return self._filled(kind(), content[-1], number)
        value = self._values[number] = self._plain(tag, content)
        return value

    def _plain(self, tag: str, content: list[Tree]) -> Any:
        match tag:
            case "array" | "scalar":
                return self._array(*content)[... if tag == "array" else ()]
            case "tensor":
                return torch.from_numpy(self._array(*content[:-1])).to(content[-1])
            case "bytes":
                return bytes(self._packs.get(Place(*content)))
            case "made":
                return self._known.made[self._known.classes[content[0]]]()
            case "enum":
                return getattr(self._known.classes[content[0]], content[1])
            case "named":
                return self._known.classes[content[0]](*(self._decoded(item) for item in content[1]))
        return _SEQUENCES[tag](self._decoded(item) for item in content[0])

    def _filled(self, mapping: Any, pairs: list[Tree], number: int) -> Any:
        self._values[number] = mapping
        for key, value in pairs:
            mapping[self._decoded(key)] = self._decoded(value)
        return mapping

    def _array(self, *packed: Any) -> np.ndarray:
        *place, dtype, shape = packed
        kind = np.dtype(dtype)
        if kind.hasobject:
            raise ValueError("an array of objects")
        return np.frombuffer(self._packs.get(Place(*place)), kind).reshape(shape)

    def _object(self, name: str, state: Tree, number: int) -> object:
        kind: Any = self._known.classes[name]
        self._values[number] = value = kind.__new__(kind)
        restored = self._decoded(state)
        if (restore := getattr(value, "__setstate__", None)) is not None:
            restore(restored)
            return value
        for field, content in restored.items():
            object.__setattr__(value, field, content)
        return value


def _state(value: Any) -> object:
    """What an object holds: its fields, what its own `__getstate__` says, or all its attributes."""
    has_own: bool = type(value).__getstate__ is not object.__getstate__  # type: ignore[comparison-overlap]
    if has_own:
        return value.__getstate__()
    if dataclasses.is_dataclass(value):
        return {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    return dict(vars(value))
