"""Devices of inference, as settings name them: "auto" is CUDA where there is one."""

from __future__ import annotations

from typing import Literal

Device = Literal["auto", "cpu", "cuda"]
