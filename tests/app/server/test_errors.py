"""Every error is a problem, with a status that the document lists."""

from __future__ import annotations

import json
import re

import pytest

from tests.support.served_maps import API, problem_of

RENAME = {"kind": "rename", "epoch": 0, "instance": 2, "name": "stool"}
CASES = [
    ("GET", "/nothing", None, 404),
    ("GET", f"{API}/nothing", None, 404),
    ("GET", f"{API}/instances/99", None, 404),
    ("GET", f"{API}/instances/0", None, 422),
    ("GET", f"{API}/instances/chair", None, 422),
    ("GET", f"{API}/instances/{2**31}", None, 422),
    ("GET", f"{API}/instances?limit=0", None, 422),
    ("GET", f"{API}/instances?min_score=nan", None, 422),
    ("GET", f"{API}/instances?colour=red", None, 422),
    ("GET", f"{API}/instances/2/crop/-1.jpg", None, 422),
    ("GET", f"{API}/instances/2/crop/0.png", None, 404),
    ("GET", f"{API}/mesh/changes", None, 422),
    ("DELETE", f"{API}/instances/2", None, 405),
    ("PUT", f"{API}/edits", None, 405),
    ("POST", f"{API}/query", {}, 422),
    ("POST", f"{API}/query", {"text": ""}, 422),
    ("POST", f"{API}/query", {"text": "   "}, 422),
    ("POST", f"{API}/query", {"text": "x" * 501}, 422),
    ("POST", f"{API}/query", {"text": "chair", "limit": 0}, 422),
    ("POST", f"{API}/query", {"text": "chair", "more": 1}, 422),
    ("POST", f"{API}/query", [], 422),
    ("POST", f"{API}/edits", {}, 422),
    ("POST", f"{API}/edits", {**RENAME, "kind": "paint"}, 422),
    ("POST", f"{API}/edits", {**RENAME, "name": "\x1b[2J"}, 422),
    ("POST", f"{API}/edits", {**RENAME, "name": ""}, 422),
    ("POST", f"{API}/edits", {**RENAME, "instance": 99}, 422),
    ("POST", f"{API}/edits", {**RENAME, "epoch": -1}, 422),
    ("POST", f"{API}/edits", {**RENAME, "epoch": 7}, 422),
    ("POST", f"{API}/edits", {"kind": "merge", "epoch": 0, "instances": [2]}, 422),
    ("POST", f"{API}/edits", {"kind": "split", "epoch": 0, "instance": 1, "region": {}}, 422),
    ("DELETE", f"{API}/edits/last", None, 409),
    ("POST", f"{API}/edits/redo", None, 409),
]


@pytest.mark.parametrize(("method", "path", "body", "status"), CASES)
def test_errors_are_problems_with_a_reason(client, method, path, body, status):
    response = client.request(method, path, json=body) if body is not None else client.request(method, path)
    problem = problem_of(response)
    assert (problem["status"], bool(problem["detail"])) == (status, True)


@pytest.mark.parametrize(
    ("body", "kind", "status"),
    [
        (b"{", "application/json", 422),
        (b"\xff\xfe", "application/json", 422),
        (b'{"text": NaN}', "application/json", 422),
        (b"[" * 100_000, "application/json", 422),
        (b"text=chair", "application/x-www-form-urlencoded", 415),
        (b"chair", "text/plain", 415),
        (b"", "", 415),
        (b"no form", "multipart/form-data; boundary=x", 422),
        (b"no form", "multipart/form-data", 422),
    ],
)
def test_questions_that_cannot_be_read(client, body, kind, status):
    response = client.post(f"{API}/query", content=body, headers={"content-type": kind})
    assert problem_of(response)["status"] == status


def test_a_method_that_is_not_taken_is_told_which_are(client):
    assert client.put(f"{API}/edits").headers["allow"] == "GET, POST"


@pytest.mark.parametrize(
    "path",
    [
        "/../../etc/passwd",
        "/..%2f..%2fetc%2fpasswd",
        f"{API}/instances/..%2f..%2fconfig.toml/crop/0.jpg",
        f"{API}/instances/2/crop/..%2f..%2f..%2fconfig.toml",
        f"{API}/instances/2/crop/0.jpg%00.toml",
        "/config.toml",
        f"{API}/config.toml",
        "/static/%2e%2e/config.toml",
    ],
)
def test_no_path_from_outside_is_opened(client, path):
    response = client.get(path)
    assert response.status_code in (404, 422)
    assert "oracle" not in response.text


def test_every_status_that_was_seen_is_documented(client):
    paths = client.get(f"{API}/openapi.json").json()["paths"]
    for method, path, _, status in CASES:
        for known, operations in paths.items():
            if method.lower() in operations and _matches(known, path):
                assert str(status) in operations[method.lower()]["responses"], (method, path)


def _matches(known: str, path: str) -> bool:
    pattern = re.sub(r"\\\{\w+\\\}", "[^/]+", re.escape(known))
    return re.fullmatch(pattern, path.partition("?")[0]) is not None


def test_the_document_has_examples_and_problems_for_every_route(client):
    document = client.get(f"{API}/openapi.json").json()
    assert document["components"]["schemas"]["Instance"]["examples"]
    assert "HTTPValidationError" not in json.dumps(document)
    for operations in document["paths"].values():
        for operation in operations.values():
            assert operation["operationId"]
            assert operation["responses"]["422"]["content"].keys() == {"application/problem+json"}


def test_headers_and_address_have_a_bound_together(client):
    assert client.get(f"{API}/edits", headers={"x-much": "x" * 15_000}).status_code == 200
    for refused in (
        client.get(f"{API}/edits", headers={"x-much": "x" * 17_000}),
        client.get(f"{API}/edits", headers={f"x-{i}": "x" * 40 for i in range(400)}),
        client.get(f"{API}/instances?text={'x' * 17_000}"),
    ):
        assert refused.status_code == 431
        assert "16 KB" in problem_of(refused)["detail"]
