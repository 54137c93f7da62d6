"""The ablation of the mapper on several seeds, as many at once as the machine, or a cluster, has room for."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rich.console import Console

from app.ablation.mapper_variants import Row, measure_variants
from app.engines.call_functions import NamedCall, call_functions
from app.engines.called_function import Call
from app.engines.engine import Engine
from app.engines.task import Needs
from app.settings.oracle_options import OracleOptions

_MB = 3500.0  # an apartment took 3,200, at 60 frames as at 300; what other scenes take is learnt


def measure_seeds(
    scene: str,
    seeds: Sequence[int],
    n_frames: int | None,
    variants: Mapping[str, Mapping[str, Any]],
    console: Console,
    strides: Sequence[int],
    options: OracleOptions,
    make_engine: Callable[[], Engine],
) -> list[dict[int, dict[str, Row]]]:
    """What `measure_variants` gives, of each seed. make_engine: makes what several seeds are measured by; a single one
    is measured here, and tells how far it is."""
    if len(seeds) == 1:
        return [measure_variants(scene, seeds[0], n_frames, variants, strides, options)]
    engine = make_engine()
    needs = Needs(_cpus(len(seeds)), _MB)
    calls = [
        NamedCall(f"seed {seed}", Call(measure_variants, (scene, seed, n_frames, variants, strides, options)), needs)
        for seed in seeds
    ]
    return list(call_functions(calls, engine, console, things="seeds").values())


def _cpus(n_seeds: int) -> float:
    """As many cores for each as there are for all at once."""
    return float(max(1, len(os.sched_getaffinity(0)) // n_seeds))
