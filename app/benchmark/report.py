"""Report of a benchmark: tables for people."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table

from app.console.streams import result_console

_MAX_SLOWEST = 3


def print_bench(result: dict[str, Any]) -> None:
    """Print what a frame takes, beside plain fusion, in which stages, and the memory."""
    console = result_console()
    of_runs = f", median of {result['repeat']} runs" if result["repeat"] > 1 else ""
    stages, plain, ratios = result["stages"], result["yardstick"], result["ratios"]
    slowest = sorted(stages, key=lambda name: -stages[name]["share"])[:_MAX_SLOWEST]
    shares = [f"{name} {stages[name]['share']:.0%}" for name in slowest]
    of_device = max(result["device_mb_at_tenths"])
    taken = f"; {of_device:.0f} MB of {result['device']}" if of_device else ""
    for line in (
        f"{result['name']}: {result['frames']} frames{of_runs}, {result['segmenter']} and {result['embedder']}",
        f"a frame: {1e3 / result['fps']:.0f} ms ({result['fps']:.1f} frames/s)",
        f"slowest stages: {', '.join(shares)}",
        f"plain TSDF fusion of the same frames: {plain['median_ms']:.1f} ms a frame; our fusion takes "
        f"{ratios['integrate']:.1f} times that, the whole map without 2D models {ratios['backend']:.1f} times",
        f"memory: {result['peak_rss_mb']:.0f} MB at most{taken}",
    ):
        console.print(line, soft_wrap=True)


def print_details(result: dict[str, Any]) -> None:
    """Print each stage, memory along the way, and the parts measured alone."""
    console = result_console()
    console.print(_stage_table(result["stages"]))
    console.print(_memory_table(result))
    _print_parts(result, console)


def _print_parts(result: dict[str, Any], console: Console) -> None:
    cpu = result["backend_cpu"]
    console.print(
        f"processor time of the map over the first {cpu['frames']} frames: {cpu['cpu_ms']:.0f} ms a frame, "
        f"{cpu['to_plain']:.1f}x plain fusion's {cpu['plain_cpu_ms']:.1f}",
        soft_wrap=True,
    )
    synth = result["synth"]
    console.print(
        f"synthetic frames with a full sensor: {synth['fps']:.1f} a second, {synth['cpu_ms']:.0f} ms of processor",
        soft_wrap=True,
    )
    evaluation = result["evaluation"]
    console.print(
        f"evaluation of {evaluation['predictions']} masks on {evaluation['vertices']} vertices: "
        f"{evaluation['cpu_s']:.1f} s of processor; reading a mask file {evaluation['read_mask_ms']:.1f} ms, "
        f"{evaluation['read_to_looking']:.0f}x looking at its bytes",
        soft_wrap=True,
    )
    decoding = result["yolo_decoding"]
    console.print(
        f"decoding of {decoding['masks']} YOLO masks: {decoding['median_ms']:.1f} ms, "
        f"{decoding['to_enlarging']:.2f}x enlarging whole masks",
        soft_wrap=True,
    )
    describing = result["describing"]
    console.print(
        f"describing {describing['masks']} masks beside the model: {describing['pooling_ms']:.1f} ms to pool a feature "
        f"map, {describing['crops_ms']:.1f} ms to cut crops",
        soft_wrap=True,
    )
    registering = result["registering"]
    console.print(
        f"bringing colour onto depth: {registering['median_ms']:.1f} ms a frame, "
        f"{registering['to_remap']:.1f}x a plain remap",
        soft_wrap=True,
    )
    ranking = result["ranking"]
    console.print(f"a query over {ranking['instances']} instances: {ranking['query_ms']:.1f} ms", soft_wrap=True)


def _stage_table(stages: dict[str, dict[str, float]]) -> Table:
    """Median, 95th percentile and share of the time of all stages, for each stage."""
    busy_s = sum(stage["total_s"] for stage in stages.values()) or 1.0
    table = Table()
    table.add_column("stage")
    for name in ("median ms", "p95 ms", "share"):
        table.add_column(name, justify="right")
    for name, stage in stages.items():
        table.add_row(name, f"{stage['median_ms']:.1f}", f"{stage['p95_ms']:.1f}", f"{stage['total_s'] / busy_s:.0%}")
    return table


def _memory_table(result: dict[str, Any]) -> Table:
    table = Table()
    for name in ("run, %", "memory, MB", "blocks"):
        table.add_column(name, justify="right")
    samples = zip(result["rss_mb_at_tenths"], result["blocks_at_tenths"], strict=True)
    for tenth, (rss_mb, blocks) in enumerate(samples, start=1):
        table.add_row(str(10 * tenth), f"{rss_mb:.0f}", str(blocks))
    return table
