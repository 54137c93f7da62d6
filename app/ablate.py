"""`razer ablate`: what each part of the method contributes, measured on synthetic scenes."""

from __future__ import annotations

from json import dumps
from typing import Annotated

from cyclopts import Parameter

from app.consoles import progress_console, result_console
from app.options import Flag
from razer.frame import BadInput


def ablate(
    *,
    scene: str = "apartment",
    seeds: str = "0,1,2",
    frames: int = 600,
    variants: Annotated[tuple[str, ...], Parameter(negative="", consume_multiple=True)] = (),
    json: Flag = False,
) -> int:
    """Map synthetic scenes with parts of the method changed, and compare what comes out.

    Masks and embeddings come from the simulator with its full noise: masks dropped, split, merged and frayed,
    embeddings of cosine 0.7 with a tenth of another class; depth and colour have a Kinect's errors, poses are given.
    All variants see the very same frames.

    Parameters
    ----------
    scene:
        The synthetic scene, as in `razer synth`.
    seeds:
        Seeds of scene and noise, with commas between; the table shows means.
    frames:
        Frames of the walk through the scene; 0 = as many as a hand-held camera needs.
    variants:
        Only these lines of the table.
    json:
        One line of JSON.
    """
    try:
        numbers = [int(seed) for seed in seeds.split(",")]
    except ValueError:
        raise BadInput(f"--seeds {seeds}: give whole numbers with commas between, such as 0,1,2") from None

    # Late, as in `razer run`.
    from app.evaluation.ablation import VARIANTS, measure, table

    unknown = [name for name in variants if name not in VARIANTS]
    if unknown:
        raise BadInput(f"no variant '{unknown[0]}': choose from {', '.join(repr(name) for name in VARIANTS)}")
    chosen = {name: VARIANTS[name] for name in variants or VARIANTS}
    rows = [measure(scene, seed, frames or None, chosen, progress_console()) for seed in numbers]
    if json:
        print(dumps({"scene": scene, "seeds": numbers, "frames": frames, "variants": rows}))
    else:
        result_console().print(table(rows, f"{scene}, mean of {len(numbers)} seeds"))
    return 0
