"""python -m tests.fuzz: changes for as long as one likes; what it finds is kept, with how to repeat it."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from tests.fuzz.corpus import KINDS
from tests.fuzz.fuzzer import Fuzzer


def main() -> int:
    """The number of findings, at most 1."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("-n", type=int, default=2000, help="changes, shared out among the kinds")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", nargs="+", choices=sorted(KINDS), default=sorted(KINDS))
    parser.add_argument("--keep", type=Path, default=Path("fuzz_findings"), help="where changed files are kept")
    asked = parser.parse_args()
    counts: Counter[str] = Counter()
    for name in asked.kinds:
        started = time.monotonic()
        with tempfile.TemporaryDirectory() as place:
            fuzzer = Fuzzer(name, Path(place), asked.seed)
            fuzzer.read_valid()
            for number in range(asked.n // len(asked.kinds)):
                if (finding := fuzzer.finding(number)) is not None:
                    counts[name] += 1
                    print(finding, flush=True)
                    asked.keep.mkdir(exist_ok=True)
                    kept = f"{name}-{asked.seed}-{number}-{Path(finding.file).name}".replace(" ", "_")
                    (asked.keep / kept).write_bytes(finding.data)
        print(f"{name}: {number + 1} changes, {counts[name]} findings, {time.monotonic() - started:.1f} s", flush=True)
    print(f"{counts.total()} findings")
    return min(counts.total(), 1)


if __name__ == "__main__":
    sys.exit(main())
