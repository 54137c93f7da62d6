"""Benchmark of the back end's processor time: all stages of the map in this process alone, nothing beside them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from time import process_time

from app.benchmark.plain_fusion import PlainFusion
from app.pipeline.prepare_run import make_mapper
from app.profiling.map_device import MapDevice
from app.settings.run_config import RunConfig
from razer.errors import UnusableFrame
from razer.frame import Frame
from razer.stages import measured_by

# Stages of the map itself; the others read, run 2D models, or log.
BACKEND = ("integrate", "lift", "associate", "vote", "maintain")


def measure_backend_cpu(frames: Sequence[Frame], config: RunConfig) -> dict[str, float]:
    """Milliseconds of processor for each frame, threads added up, of the map's stages and of plain TSDF fusion, and
    their ratio. Unlike times by the clock they do not depend on what else a machine does."""
    mapper, cpu_s = make_mapper(config), defaultdict[str, float](float)
    device = MapDevice(str(mapper.voxels.device))

    @contextmanager
    def measure(name: str) -> Iterator[None]:
        started_s = process_time()
        yield
        cpu_s[name] += process_time() - started_s

    with measured_by(measure):
        for frame in frames:
            with suppress(UnusableFrame):
                mapper.step(frame)
    backend_ms = 1e3 * sum(cpu_s[name] for name in BACKEND) / len(frames)
    plain = PlainFusion(config.voxels, mapper.voxels.n_blocks, device, process_time)
    plain_ms = sum(map(plain.fuse_ms, frames)) / len(frames)
    return {
        "frames": len(frames),
        "cpu_ms": round(backend_ms, 2),
        "plain_cpu_ms": round(plain_ms, 2),
        "to_plain": round(backend_ms / plain_ms, 2),
    }
