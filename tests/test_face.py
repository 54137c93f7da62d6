"""The importable face: which names there are, and what importing them costs."""

from __future__ import annotations

import importlib
import subprocess
import sys

import pytest

from tests.support.edited_maps import saved

FACES = {
    "razer": {
        "BadInput", "Frame", "Intrinsics", "Mapper", "MapperConfig", "Masks", "PanopticMap", "RazerError",
        "UnusableFrame", "__version__", "load_map", "make_embedder", "make_segmenter",
    },
    "slam": {"GivenPoses", "SlamSystem"},
    "data_tools": {"open_sequence", "write_recording"},
}  # fmt: skip


@pytest.mark.parametrize("package", FACES)
def test_the_face_has_these_names_and_each_can_be_had(package):
    module = importlib.import_module(package)
    assert set(module.__all__) == FACES[package]
    for name in module.__all__:
        assert getattr(module, name) is not None
        assert name in dir(module)
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = module.no_such_name


@pytest.mark.parametrize("package", FACES)
def test_importing_a_face_loads_nothing_heavy(package):
    heavy = ("numpy", "torch", "open3d", "cv2", "pydantic")
    code = f"import sys, {package}; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_saved_map_is_asked_without_open3d_and_torch(tmp_path):
    """They take seconds to load, and neither names nor boxes need them."""
    folder = saved(tmp_path / "map")
    code = (
        "import sys, razer\n"
        f"panoptic = razer.load_map({str(folder)!r}, embedder='oracle')\n"
        "assert panoptic.query('a chair').found and panoptic.query('furniture').found\n"
        "print([m for m in ('torch', 'open3d', 'scipy.spatial', 'scipy.special') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "app", "query", folder, "a chair", "--embedder", "oracle"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    loaded = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines() if line.startswith("import time")}
    assert "razer.panoptic_map" in loaded
    assert not loaded & {"torch", "open3d", "scipy.special", "scipy.ndimage"}


def test_help_loads_neither_numpy_nor_torch():
    code = (
        "import sys\nfrom app.cli import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        "print([m for m in ('numpy', 'torch', 'open3d') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.rstrip().endswith("[]")


def test_errors_are_kin():
    import razer

    assert issubclass(razer.UnusableFrame, razer.BadInput)
    assert issubclass(razer.BadInput, razer.RazerError)


VERBS = (
    "run", "track", "demo", "query", "label", "edit", "view", "inspect", "config",
    "eval", "compare", "reproduce", "ablate", "bench", "convert", "synth",
)  # fmt: skip
LOADED_BY_HELP = """
import contextlib, io, sys
from app.cli import main
for verb in sys.argv[1:]:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
        main([verb, "--help"])
    print(verb, [m for m in ("open3d", "torch", "matplotlib", "rerun") if m in sys.modules])
"""


def test_the_help_of_a_verb_loads_nothing_heavy():
    """What a verb imports at its top is loaded before it can say how many cores Open3D may take."""
    done = subprocess.run([sys.executable, "-c", LOADED_BY_HELP, *VERBS], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [f"{verb} []" for verb in VERBS]
