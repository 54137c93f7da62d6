"""`razer ablate`: ablation study on synthetic scenes."""

from __future__ import annotations

from dataclasses import dataclass
from json import dumps
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from app.console.outputs import print_next
from app.console.streams import progress_console, result_console
from app.console.waiting import waiting_for
from app.engines.engine_options import EngineOptions
from app.next_steps import looking_at
from app.settings.number_lists import whole_numbers
from app.settings.options import Flag
from app.settings.oracle_options import OracleErrors, OracleOptions, oracle_options
from razer.errors import BadInput


@Parameter(name="*")
@dataclass(frozen=True)
class OtherAblations:
    """What is measured instead of maps."""

    queries: Path | None = None
    """Measure retrieval by text instead, on this npz with names, synonyms, text and image embeddings; 60 names of each
    draw are in the map, 60 are not."""
    draws: int = 50
    """Number of random draws of names for --queries."""
    naming: Annotated[tuple[Path, ...] | None, Parameter(negative="", consume_multiple=True)] = None
    """Measure naming instead, on these finished runs of recordings with a truth, and fit its weights to them."""


def ablate(
    *,
    scene: str = "apartment",
    seeds: str = "0,1,2",
    frames: int = 600,
    stride: str = "1",
    noise: OracleErrors = "full",
    exemplars: Path | None = None,
    variants: Annotated[tuple[str, ...], Parameter(negative="", consume_multiple=True)] = (),
    instead: OtherAblations = OtherAblations(),
    engine: EngineOptions = EngineOptions(),  # noqa: B008
    json: Flag = False,
) -> int:
    """Compare maps of synthetic scenes: the paper's way, ours with each departure taken back alone, and ours.

    Masks and embeddings come from the simulator, depth and colour have a Kinect's errors, poses are given. All variants
    see the very same frames, which wait in the temporary folder: some 5 MB each, twice.

    Parameters
    ----------
    scene:
        The synthetic scene, as in `razer synth`.
    seeds:
        Seeds of scene and noise, with commas between; the table shows means.
    frames:
        Frames along the camera path; 0 = as many as a hand-held camera needs.
    stride:
        Map only every n-th frame; several with commas between, each a line of its own. Walk and truth are the same.
    noise:
        Errors of masks and embeddings: none, full, or as models have them; detector and panoptic need --exemplars.
    exemplars:
        An npz as --queries takes: embeddings of masks are those of images in it, with CLIP's errors.
    variants:
        Only these variants.
    json:
        One line of JSON.
    """
    if instead.queries is not None:
        return _ablate_queries(instead.queries, instead.draws, json)
    if instead.naming is not None:
        if not instead.naming:
            raise BadInput("--naming needs finished runs: razer ablate --naming RUN ...")
        return _ablate_naming(instead.naming, json)
    seed_numbers = whole_numbers("--seeds", seeds, 0)
    strides = whole_numbers("--stride", stride, 1)
    rows = _measure(scene, seed_numbers, strides, frames, variants, oracle_options(noise, exemplars), engine)
    asked = {"scene": scene, "seeds": seed_numbers, "frames": frames, "noise": noise} | _by_stride(rows, strides)
    _print(asked if json else None, rows, f"{scene}, mean of {len(seed_numbers)} seeds")
    return 0


def _print(document: dict[str, Any] | None, rows: list[dict[int, Any]], title: str) -> None:
    """One line of JSON if there is a document, else the table, and what to do next."""
    if document is not None:
        print(dumps(document))
        return
    from app.ablation.mapper_variants import variants_table

    result_console().print(variants_table(rows, title))
    print_next(("config",))  # the settings that the variants change


def _measure(
    scene: str,
    seeds: list[int],
    strides: list[int],
    frames: int,
    variants: tuple[str, ...],
    options: OracleOptions,
    engine: EngineOptions,
) -> list[dict[int, Any]]:
    """The rows of each seed, by stride; raises BadInput for a variant that there is not."""
    # Late, as in `razer run`.
    with waiting_for("starting"):
        from app.ablation.mapper_variants import VARIANTS
        from app.ablation.measure_seeds import measure_seeds

    unknown = [name for name in variants if name not in VARIANTS]
    if unknown:
        raise BadInput(f"no variant '{unknown[0]}': choose from {', '.join(repr(name) for name in VARIANTS)}")
    chosen = {name: VARIANTS[name] for name in variants or VARIANTS}
    console = progress_console()
    return measure_seeds(scene, seeds, frames or None, chosen, console, strides, options, engine.engine)


def _by_stride(rows: list[dict[int, Any]], strides: list[int]) -> dict[str, Any]:
    """The rows of each stride, and those of the first once more by themselves."""
    by_stride = [{"stride": stride, "variants": [row[stride] for row in rows]} for stride in strides]
    return {"strides": strides, "variants": by_stride[0]["variants"], "by_stride": by_stride}


def _ablate_naming(runs: tuple[Path, ...], json: bool) -> int:
    with waiting_for("matching the runs with their truths and naming them by each rule"):
        from app.ablation.matched_run import MatchedRun
        from app.ablation.naming_ablation import measure_naming, naming_table
        from app.ablation.text_questions import measure_questions

        opened = [MatchedRun.open(run) for run in runs]
        rows, questions = measure_naming(opened), measure_questions(opened)
    if json:
        print(dumps({"naming": [str(run) for run in runs], "rules": rows, "questions": questions}))
        return 0
    result_console().print(naming_table(rows))
    result_console().print(
        "asked for {n_there} classes that are there: {top1:.1%} of the best answers are right; present or not, with "
        "{n_absent} others: precision {present_precision:.1%}, recall {present_recall:.1%}".format(**questions),
        soft_wrap=True,
    )
    print_next(*(looking_at(run) for run in runs))
    return 0


def _ablate_queries(path: Path, draws: int, json: bool) -> int:
    from app.ablation.exemplars import Exemplars
    from app.ablation.query_ablation import mean_scores, measure_queries, presence_table, retrieval_table

    if draws < 1:
        raise BadInput(f"--draws {draws}: give at least 1")
    with waiting_for("drawing names and asking for them"):
        rows = {name: mean_scores(scores) for name, scores in measure_queries(Exemplars.read(path), draws).items()}
    if json:
        print(dumps({"queries": str(path), "draws": draws, "banks": rows}))
        return 0
    result_console().print(retrieval_table(rows))
    result_console().print(presence_table(rows))
    print_next(("ablate", "--exemplars", path))
    return 0
