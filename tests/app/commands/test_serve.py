"""`razer serve`, `mcp` and `run --serve`: what they refuse, in one plain line and before anything else."""

from __future__ import annotations

import sys

import pytest

from tests.support.cli import razer
from tests.support.served_maps import TOKEN, saved_map

LIBRARIES = ["fastapi", "uvicorn", "python_multipart", "PIL", "mcp"]


def refused(capsys, *arguments) -> str:
    """What a refused command says."""
    code, out, err = razer(capsys, *arguments)
    assert (code, out) == (2, "")
    assert len(err.strip().splitlines()) == 1
    return err


@pytest.mark.parametrize("missing", LIBRARIES)
@pytest.mark.parametrize("verb", [("serve", "RUN"), ("mcp", "RUN"), ("bench", "--serve")])
def test_without_the_extra_it_is_named(capsys, monkeypatch, verb, missing):
    monkeypatch.setitem(sys.modules, missing, None)
    assert "razer[serve]" in refused(capsys, *verb)


def test_a_run_that_cannot_be_served_is_not_begun(capsys, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "fastapi", None)
    assert "razer[serve]" in refused(capsys, "run", tmp_path, "-o", tmp_path / "out", "--serve")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("verb", ["serve", "mcp"])
def test_what_is_no_map_is_refused(capsys, tmp_path, verb):
    assert str(tmp_path) in refused(capsys, verb, tmp_path)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--host", "0.0.0.0"], "--token"),
        (["--host", "0.0.0.0", "--token", "short"], "--token"),
        (["--port", "70000"], "--port"),
        (["--port", "-1"], "--port"),
        (["--host", "no.such.host.invalid", "--token", TOKEN], "--host"),
    ],
)
def test_places_that_cannot_be_listened_on(capsys, tmp_path, options, named):
    folder = saved_map(tmp_path / "run")
    assert named in refused(capsys, "serve", folder, *options)
    http = [{"--port": "--http"}.get(option, option) for option in options]
    extra = [] if "--http" in http else ["--http", "0"]
    assert named in refused(capsys, "mcp", folder, *http, *extra)


def test_a_token_may_come_from_the_environment(capsys, monkeypatch, tmp_path):
    folder = saved_map(tmp_path / "run")
    monkeypatch.setenv("RAZER_TOKEN", "short")
    assert "--token" in refused(capsys, "serve", folder)


def test_two_runs_are_not_served_at_once(capsys, tmp_path):
    assert "--serve" in refused(capsys, "run", tmp_path, "-o", tmp_path / "out", "--poses", "both", "--serve")


def test_an_embedder_from_outside_is_not_loaded_because_the_map_names_it(capsys, tmp_path):
    folder = saved_map(tmp_path / "run")
    (folder / "config.toml").write_text('[embedder]\nname = "os:getcwd"\n')
    assert "--trust-plugins" in refused(capsys, "serve", folder)
