"""Settings that choose a plug-in: its name, its options, and how far it is trusted."""

from __future__ import annotations

from typing import Any, Self

from pydantic import Field, PrivateAttr

from razer.plugins import NO_TRUST, Trust
from razer.settings import Settings


class PluginSettings(Settings):
    """A section that names a part. Which outside code it may name is said by whoever runs the program, never by a
    file: it is no setting."""

    _trust: Trust = PrivateAttr(default=NO_TRUST)

    @property
    def trust(self) -> Trust:
        """Which outside code may be loaded."""
        return self._trust

    def trusting(self, trust: Trust) -> Self:
        """The same settings with more trust."""
        copy = self.model_copy()
        copy._trust = trust
        return copy

    def __eq__(self, other: object) -> bool:
        """Whether the settings are the same; trust is none of them."""
        return isinstance(other, type(self)) and self.model_dump() == other.model_dump()


class SegmenterSettings(PluginSettings):
    """What finds masks."""

    name: str = Field(
        "geometric", description="geometric, yolo, sam, prompted, panoptic, oracle, masks, or an outside module:Class."
    )
    options: dict[str, Any] = Field({}, description="Its named arguments, such as noise = 'full'.")


class EmbedderSettings(PluginSettings):
    """What describes masks by vectors."""

    name: str = Field("appearance", description="appearance, clip, names, oracle, or an outside module:Class.")
    options: dict[str, Any] = Field({}, description="Its named arguments.")
