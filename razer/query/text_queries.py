"""Text queries: prompt ensembles encoded by an embedder, and the negative prompts that queries compete with."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import chain
from typing import Self

import numpy as np

from razer.arrays import Float32Array
from razer.errors import BadInput
from razer.models import NameTable, TextEncoder
from razer.query.kinds import NameSet, all_kinds, expand, near_kinds
from razer.query.ranking import NegativePrompts
from razer.vocabulary import VOCABULARIES, vocabulary

# A text encoder knows captions better than words; the prompt templates' own meaning is averaged away.
TEMPLATES = ("a photo of a {}.", "a {} in a room.", "a cropped photo of the {}.")
# Every third of the 1,203 names of LVIS, with near as much to say as all (precision 0.88 instead of 0.89 where 80 % of
# what is present is retrieved), since each name costs an encoder some ten milliseconds; and words that mean nothing.
EVERY_NAME = 3
MAX_CHARACTERS = 2000  # of a text; encoders look at some 300
NEUTRAL = ("object", "thing", "things", "stuff", "texture", "surface", "background")
_ARTICLE = re.compile(r"^(a|an|the)\s+", re.IGNORECASE)


def _require_words(text: str) -> None:
    """Raise BadInput for a text that is too long, or has bytes in it that the terminal could not read."""
    if len(text) > MAX_CHARACTERS:
        raise BadInput(f"a text of {len(text):,} characters is too long: {MAX_CHARACTERS:,} are the most")
    if not text.isascii() and any("\ud800" <= character <= "\udfff" for character in text):
        raise BadInput(f"'{text}' is no UTF-8 text: write it anew")


class TextQueryEncoder:
    """The text encoder of an embedder. It may have none: what needs text then raises BadInput."""

    def __init__(
        self, embedder: object, negatives: NegativePrompts | None = None, templates: Sequence[str] = TEMPLATES
    ) -> None:
        """`negatives`, where they are known already, need not be embedded; templates: sentences with {} for a text."""
        self._make = lambda: embedder
        self._known_negatives = negatives
        self._templates = templates

    @classmethod
    def deferred(cls, make: Callable[[], object]) -> Self:
        """One whose embedder is made when the first text comes."""
        encoder = cls(None)
        encoder._make = make
        return encoder

    @cached_property
    def embedder(self) -> object:
        """The embedder, which may know no words."""
        return self._make()

    @property
    def knows_words(self) -> bool:
        """Whether texts can be asked for."""
        return isinstance(self.embedder, TextEncoder)

    @property
    def text_encoder(self) -> TextEncoder:
        """The embedder; raises BadInput if it knows no words."""
        if not isinstance(self.embedder, TextEncoder):
            raise BadInput(
                "the embedder of this map has no text encoder, it knows looks and no words: map with another "
                "--embedder ('razer models pull starter' brings one), or ask with --image"
            )
        return self.embedder

    @property
    def is_table(self) -> bool:
        """Whether only the names of a table are known, whose vectors are at hand."""
        return isinstance(self.text_encoder, NameTable) and not getattr(self.text_encoder, "takes_any_name", False)

    @property
    def embeds_names(self) -> bool:
        """Whether the vectors of masks are those of their names, and so say what these say once more."""
        return bool(getattr(self.embedder, "embeds_names", False))

    def vectors(self, texts: Sequence[str]) -> Float32Array:
        """Unit vectors (N, D) of texts; raises BadInput for a text that a table of names does not have."""
        side = self.text_encoder
        if not texts or not all(text.strip() for text in texts):
            raise BadInput("an empty text means nothing: give a name or a short description")
        for text in texts:
            _require_words(text)
        bare = [_ARTICLE.sub("", text.strip()) for text in texts]
        if isinstance(side, NameTable):
            return side.embed_texts(bare)
        prompts = [template.format(text) for text in bare for template in self._templates]
        means = side.embed_texts(prompts).reshape(len(texts), len(self._templates), -1).mean(axis=1)
        return means / np.linalg.norm(means, axis=1, keepdims=True)

    def knows(self, name: str) -> bool:
        """Whether a name has a vector: a table does not have all of them."""
        if not self.is_table:
            return True
        if has_name := getattr(self.text_encoder, "has_name", None):  # tables of names have it
            return bool(has_name(name))
        try:
            self.vectors([name])
        except BadInput:
            return False
        return True

    def query_vector(self, text: str) -> Float32Array:
        """The unit vector (1, D) of a text; raises BadInput where a table lacks it, with kinds that it might mean."""
        try:
            return self.vectors([text])
        except BadInput as error:
            if not text.strip() or not self.is_table:
                raise
            near = ", ".join(near_kinds(text)) or 'furniture or "something to sit on"'
            raise BadInput(f"{error}; it can be asked for kinds, too, such as {near}") from error

    def meaning(self, text: str) -> NameSet | None:
        """Those of `choices` that a kind of thing, a purpose or an enumeration stands for; None for any other text, and
        for encoders, which know what words mean. Raises BadInput where a table has no name of the kind."""
        if not self.is_table or (found := expand(text, self.choices.names)) is None:
            return None
        if not len(found.rows) and not self.knows(text):
            raise BadInput(f"none of the {len(self.choices.names)} names that the embedder knows is meant by '{text}'")
        return found if len(found.rows) else None

    @cached_property
    def choices(self) -> NegativePrompts:
        """The names that a kind's are taken from: all that a table has, or those of all vocabularies where any name has
        a vector."""
        if getattr(self.text_encoder, "known_names", ()):
            return self.negatives
        lists = (*(vocabulary(name).names for name in VOCABULARIES), *(kind.names for kind in all_kinds()))
        names = tuple(dict.fromkeys(chain.from_iterable(lists)))
        return NegativePrompts(names, self.vectors(names))

    @property
    def negative_names(self) -> tuple[str, ...]:
        """The names of the negative prompts: all that a table has, or else names of LVIS."""
        side = self.text_encoder
        if isinstance(side, NameTable):
            return tuple(side.known_names) or vocabulary("lvis").names
        return (*vocabulary("lvis").names[::EVERY_NAME], *NEUTRAL)

    @cached_property
    def negatives(self) -> NegativePrompts:
        """What queries compete with; embedded once."""
        if self._known_negatives is not None:
            return self._known_negatives
        names = self.negative_names
        if len(names) < 2:
            raise BadInput(
                "a table of a single name cannot tell what is there from what is not: give one of many names"
            )
        return NegativePrompts(names, self.vectors(names))
