"""Rerun's own program as a process that tells nobody what it is used for."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

_CONFIG = Path("rerun", "analytics.json")


def rerun_command(*arguments: str) -> list[str]:
    """The command line of Rerun's program, as it is installed beside this interpreter."""
    return [sys.executable, "-m", "rerun_cli", *arguments]


def rerun_environment() -> dict[str, str]:
    """The environment for it: warnings only, and a configuration in which it collects no data on its use."""
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "razer" / "viewer"
    config = folder / _CONFIG
    off = {"analytics_enabled": False, "analytics_id": "", "metadata": {}}
    paths = {"config_file_path": str(config), "data_dir_path": str(config.parent / "analytics")}
    config.parent.mkdir(parents=True, exist_ok=True)
    config.write_text(json.dumps(off | paths))
    return {"RUST_LOG": "warn"} | os.environ | {"XDG_CONFIG_HOME": str(folder)}
