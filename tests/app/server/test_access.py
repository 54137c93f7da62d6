"""Who is let in: by host, origin and token; and within which bounds."""

from __future__ import annotations

import pytest

from app.server import guard
from app.server.access_rules import AccessRules
from razer.errors import BadInput
from tests.support.served_maps import API, TOKEN, client_of, problem_of

QUERY = {"text": "chair"}


@pytest.mark.parametrize("host", ["127.0.0.1:8700", "localhost:8700", "[::1]:8700", "localhost", "localhost:9999"])
def test_loopback_names_are_known(client, host):
    assert client.get(f"{API}/instances", headers={"Host": host}).status_code == 200


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "evil.example:8700",
        "127.0.0.1.evil.example:8700",
        "localhost.evil.example",
        "192.168.0.7",
        "",
        "a b",
    ],
)
def test_a_rebound_name_is_refused(client, host):
    for path in ("/", f"{API}/instances", f"{API}/events", f"{API}/page"):
        assert problem_of(client.get(path, headers={"Host": host}))["status"] == 421


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "null", "https://127.0.0.1:9999", "http://127.0.0.1", "http://localhost:8700", "file://"],
)
def test_a_foreign_page_can_neither_ask_nor_edit_nor_listen(client, origin):
    foreign = {"Origin": origin}
    assert problem_of(client.post(f"{API}/query", json=QUERY, headers=foreign))["status"] == 403
    assert problem_of(client.delete(f"{API}/edits/last", headers=foreign))["status"] == 403
    assert problem_of(client.get(f"{API}/events", headers=foreign))["status"] == 403


def test_the_own_page_may_ask(client):
    own = {"Origin": "http://127.0.0.1:8700"}
    response = client.post(f"{API}/query", json=QUERY, headers=own)
    assert response.status_code == 200
    assert "access-control-allow-origin" not in response.headers


def test_a_form_of_another_site_is_refused(client):
    assert client.post(f"{API}/edits/redo", headers={"Sec-Fetch-Site": "cross-site"}).status_code == 403


def test_answers_bear_the_headers_that_browsers_heed(client):
    for path in ("/", f"{API}/instances", "/nothing"):
        headers = client.get(path).headers
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["x-frame-options"] == "DENY"
        assert "frame-ancestors 'none'" in headers["content-security-policy"]
        assert "server" not in headers


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.0.7", "::", "example.org"])
def test_another_host_needs_a_token(host):
    with pytest.raises(BadInput, match="--token"):
        AccessRules(host)
    assert AccessRules(host, TOKEN).admits(TOKEN)


@pytest.mark.parametrize("token", ["", "short", "with spaces in it ok", "grüße-grüße-grüße", "line\nline-line-line"])
def test_tokens_that_could_be_guessed_or_not_be_sent_are_refused(token):
    with pytest.raises(BadInput, match="--token"):
        AccessRules("127.0.0.1", token)


def test_with_an_open_address_names_that_could_be_rebound_are_still_unknown():
    rules = AccessRules("0.0.0.0", TOKEN)
    assert rules.knows_host("192.168.0.7:8700")
    assert rules.knows_host("[fe80::1]:8700")
    assert not rules.knows_host("evil.example:8700")


@pytest.fixture
def locked(served):
    with client_of(served, AccessRules("127.0.0.1", TOKEN)) as client:
        yield client


def test_without_the_token_nothing_is_told(locked):
    for path in ("/", f"{API}/instances", f"{API}/openapi.json", f"{API}/page", "/nothing"):
        assert problem_of(locked.get(path))["status"] == 401


@pytest.mark.parametrize("token", ["", TOKEN[:-1], TOKEN + "x", TOKEN.upper(), "é" * 20])
def test_a_wrong_token_is_refused(locked, token):
    bearer = {"Authorization": f"Bearer {token}".encode()}
    assert problem_of(locked.get(f"{API}/instances", headers=bearer))["status"] == 401
    assert problem_of(locked.get("/", params={"token": token}))["status"] == 401


def test_the_token_opens_as_bearer(locked):
    assert locked.get(f"{API}/instances", headers={"Authorization": f"Bearer {TOKEN}"}).status_code == 200


def test_the_token_in_the_address_becomes_a_cookie_that_scripts_do_not_see(locked):
    response = locked.get("/", params={"token": TOKEN}, follow_redirects=False)
    assert (response.status_code, response.headers["location"]) == (303, "/")
    cookie = response.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert locked.get(f"{API}/instances").status_code == 200


def test_many_wrong_tokens_are_not_looked_at_but_the_right_one_is(locked):
    statuses = [locked.get(f"{API}/instances", headers={"Authorization": "Bearer no"}).status_code for _ in range(30)]
    assert statuses[0] == 401
    assert statuses[-1] == 429
    assert locked.get(f"{API}/instances", headers={"Authorization": f"Bearer {TOKEN}"}).status_code == 200


def test_what_is_too_large_is_refused_whether_it_says_so_or_not(client):
    large = b'{"text": "' + b"x" * guard.MAX_JSON_BYTES + b'"}'
    json = {"content-type": "application/json"}
    assert problem_of(client.post(f"{API}/query", content=large, headers=json))["status"] == 413
    pieces = (large[start : start + 65536] for start in range(0, len(large), 65536))
    assert problem_of(client.post(f"{API}/query", content=pieces, headers=json))["status"] == 413


def test_too_many_at_once_are_refused(served, monkeypatch):
    monkeypatch.setattr(guard, "MAX_IN_FLIGHT", 0)
    with client_of(served) as client:
        response = client.get(f"{API}/instances")
    assert problem_of(response)["status"] == 503
    assert response.headers["retry-after"]


def test_more_questions_than_may_wait_are_refused(client, served):
    served.pool._free = 0
    response = client.post(f"{API}/query", json=QUERY)
    assert problem_of(response)["status"] == 429
    assert response.headers["retry-after"]
