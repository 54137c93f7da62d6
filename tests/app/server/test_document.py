"""The interface by its own document: what a fuzzer makes of it, and a client that a generator makes."""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
import sysconfig
from io import BytesIO
from pathlib import Path

import httpx
import pytest

from tests.app.served_map.test_query_picture import encoded
from tests.support.edited_maps import CHAIR, NAMES, OTHER_CHAIR
from tests.support.served_maps import API, saved_map, server_process

pytestmark = pytest.mark.full
SCRIPTS = Path(sysconfig.get_path("scripts"))
# A rename of an instance that is not there is right by the document, and refused all the same; so is a picture where
# the embedder takes words alone.
NOT_CHECKED = "positive_data_acceptance"
# A stream of events never ends, which the fuzzer takes for a server that hangs; test_event_streams.py has them.
NOT_ASKED = f"{API}/events"


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory):
    with server_process(saved_map(tmp_path_factory.mktemp("documented") / "run")) as (_, address):
        yield address


def test_schemathesis_finds_no_5xx_and_no_status_or_answer_that_is_not_documented(address, tmp_path):
    command = [
        SCRIPTS / "schemathesis", "run", f"{address}api/v1/openapi.json", "--exclude-path", NOT_ASKED, "--seed", "1",
        "--max-examples", "40", "--phases", "examples,coverage,fuzzing", "--generation-database", "none",
        "--exclude-checks", NOT_CHECKED, "--continue-on-failure", "--no-color",
    ]  # fmt: skip
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=280)
    assert done.returncode == 0, done.stdout[-6000:]
    assert "Tested: 13" in done.stdout


@pytest.fixture(scope="module")
def client_package(address, tmp_path_factory: pytest.TempPathFactory):
    """A client that openapi-python-client has made of the document; a warning fails it."""
    place = tmp_path_factory.mktemp("generated")
    (place / "openapi.json").write_bytes(httpx.get(f"{address}api/v1/openapi.json", timeout=20).content)
    binary = dict.fromkeys(["image/jpeg", "model/gltf-binary", "text/event-stream"], "application/octet-stream")
    (place / "config.json").write_text(json.dumps({"content_type_overrides": binary}))
    command = [
        SCRIPTS / "openapi-python-client", "generate", "--path", "openapi.json", "--meta", "none", "--output-path",
        "made_client", "--config", "config.json", "--fail-on-warning",
    ]  # fmt: skip
    environment = os.environ | {"PATH": f"{SCRIPTS}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(command, cwd=place, capture_output=True, text=True, env=environment, timeout=120)
    assert done.returncode == 0, done.stdout
    sys.path.insert(0, str(place))
    yield "made_client"
    sys.path.remove(str(place))


def test_a_generated_client_works(address, client_package):
    def operation(name: str):
        return importlib.import_module(f"{client_package}.api.{name}")

    models = importlib.import_module(f"{client_package}.models")
    client = importlib.import_module(client_package).Client(
        base_url=address.rstrip("/"), raise_on_unexpected_status=True
    )

    listed = operation("map_.list_instances").sync(client=client, class_="chair")
    assert [instance.id for instance in listed.instances] == [CHAIR, OTHER_CHAIR]
    chair = operation("map_.get_instance").sync(CHAIR, client=client)
    assert (chair.name, chair.kind.value) == ("chair", "thing")
    answer = operation("query.query").sync(client=client, body=models.TextQuery(text="lamp", limit=3))
    assert [hit.name for hit in answer.hits] == ["lamp"]
    mesh = operation("map_.get_mesh").sync(client=client)
    assert mesh.payload.read(4) == b"glTF"

    epoch = listed.epoch
    request = models.RenameRequest(kind="rename", epoch=epoch, instance=CHAIR, name="throne", author="Ada")
    done = operation("edits.edit").sync(client=client, body=request)
    assert (done.epoch, done.edit.kind) == (epoch + 1, "rename")
    late = operation("edits.edit").sync(client=client, body=request)
    assert (late.status, late.type_) == (409, "stale")
    assert operation("edits.list_edits").sync(client=client).can_undo
    operation("edits.undo").sync(client=client)
    assert operation("map_.get_instance").sync(CHAIR, client=client).name == NAMES[CHAIR]
    assert operation("map_.get_instance").sync(99, client=client).status == 404


def test_a_generated_client_sends_pictures(address, client_package):
    types = importlib.import_module(f"{client_package}.types")
    models = importlib.import_module(f"{client_package}.models")
    query = importlib.import_module(f"{client_package}.api.query.query")
    client = importlib.import_module(client_package).Client(base_url=address.rstrip("/"))
    body = models.QueryFilesBody(image=types.File(payload=BytesIO(encoded("PNG")), file_name="x.png"), limit=3)
    refused = query.sync(client=client, body=body)
    assert "takes no pictures" in refused.detail
