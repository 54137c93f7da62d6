"""Command-line options of a synthetic recording whose colour is not that of the camera it declares."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from razer.errors import BadInput

if TYPE_CHECKING:
    from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment

# Negative numbers begin as options do.
Numbers = Annotated[str, Parameter(allow_leading_hyphen=True)]


@Parameter(name="*")
@dataclass(frozen=True)
class MisalignmentOptions:
    """The true colour camera, where it is not the declared one."""

    rgb_zoom: float = 1.0
    """Focal length of colour relative to depth's. What is declared stays one camera for both; the truth says which."""
    rgb_shift: Numbers = "0,0"
    """X,Y: by how many pixels of the image colour lies further to the right and down than depth."""
    rgb_baseline: Numbers = "0,0,0"
    """X,Y,Z: where the colour camera stands in the depth camera (right, down, forward), metres."""

    def misalignment(self) -> RgbdMisalignment:
        """How the colour camera differs from the depth camera; raises BadInput."""
        from data_tools.synthetic.camera.rgbd_misalignment import RgbdMisalignment

        right, down = _numbers("--rgb-shift", self.rgb_shift, "X,Y")
        x, y, z = _numbers("--rgb-baseline", self.rgb_baseline, "X,Y,Z")
        return RgbdMisalignment(self.rgb_zoom, (right, down), (x, y, z))


def _numbers(option: str, text: str, form: str) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != form.count(",") + 1:
        raise BadInput(f"{option} {text}: write it as {form}")
    return numbers
