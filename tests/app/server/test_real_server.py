"""The server as a process: slow clients, many streams, a quick end, two editors at once."""

from __future__ import annotations

import json
import signal
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from pathlib import Path
from urllib.parse import urlsplit

import httpx
import pytest

from app.server.event_streams import MAX_STREAMS
from app.server.run_server import HEADER_TIMEOUT_S, MAX_CONNECTIONS
from tests.support.edited_maps import CHAIR
from tests.support.served_maps import API, saved_map, server_process

pytestmark = pytest.mark.full


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return saved_map(tmp_path_factory.mktemp("served") / "run")


@pytest.fixture(scope="module")
def address(folder):
    with server_process(folder) as (_, address):
        yield address


def connect(address: str) -> socket.socket:
    parts = urlsplit(address)
    return socket.create_connection((parts.hostname, parts.port), timeout=60)


def request(address: str, path: str, method: str = "GET", **headers: str) -> bytes:
    lines = [
        f"{method} {path} HTTP/1.1",
        f"Host: {urlsplit(address).netloc}",
        *(f"{k}: {v}" for k, v in headers.items()),
    ]
    return "\r\n".join([*lines, "", ""]).encode()


def until_closed(connection: socket.socket) -> bytes:
    data = b""
    try:
        while piece := connection.recv(65536):
            data += piece
    except ConnectionResetError:
        pass
    return data


def answers(address: str) -> bool:
    return httpx.get(f"{address.rstrip('/')}{API}/instances", timeout=20).status_code == 200


def test_headers_that_never_end_are_cut_off_and_others_are_served(address):
    slow = [connect(address) for _ in range(20)]
    for connection in slow:
        connection.sendall(b"GET / HTTP/1.1\r\nHost: ")
    assert answers(address)
    started_s = time.monotonic()
    for connection in slow:
        assert until_closed(connection) == b""
    assert time.monotonic() - started_s < HEADER_TIMEOUT_S + 5


def test_headers_sent_drop_by_drop_are_cut_off(address):
    connection = connect(address)
    started_s = time.monotonic()
    try:
        while time.monotonic() - started_s < 3 * HEADER_TIMEOUT_S:
            connection.sendall(b"G" if time.monotonic() == started_s else b"X-A: b\r\n")
            time.sleep(0.5)
    except OSError:
        pass
    assert time.monotonic() - started_s < 2 * HEADER_TIMEOUT_S


def test_a_body_that_never_comes_is_given_up(address):
    connection = connect(address)
    headers = {"Content-Type": "application/json", "Content-Length": "100"}
    connection.sendall(request(address, f"{API}/query", "POST", **headers) + b'{"text"')
    answer = until_closed(connection)
    assert b" 408 " in answer.splitlines()[0]


@pytest.mark.parametrize(
    "data",
    [b"\x00\x01\x02\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"GET  / HTTP/1.1\r\n\r\n", b"A" * 100_000,
     b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", b"GET / HTTP/1.1\r\nX: " + b"y" * 100_000 + b"\r\n\r\n",
     b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\nGET"],
)  # fmt: skip
def test_what_is_no_request_is_refused(address, data):
    connection = connect(address)
    connection.sendall(data)
    connection.shutdown(socket.SHUT_WR)
    first = until_closed(connection).splitlines()[:1]
    assert not first or first[0].split()[1].startswith(b"4")
    assert answers(address)


def test_a_thousand_event_streams_are_bounded_and_the_map_is_still_answered(address):
    with ExitStack() as stack:
        connections = [stack.enter_context(connect(address)) for _ in range(1000)]
        for connection in connections:
            with suppress(OSError):  # refused before it could ask
                connection.sendall(request(address, f"{API}/events"))
        statuses = [_status(connection) for connection in connections]
        assert statuses.count(200) == MAX_STREAMS
        assert statuses.count(503) + statuses.count(0) == 1000 - MAX_STREAMS
        assert len(connections) > MAX_CONNECTIONS
        deadline_s = time.monotonic() + 20
        while time.monotonic() < deadline_s and not answers(address):
            time.sleep(0.5)
        assert answers(address)
    deadline_s = time.monotonic() + 20
    while time.monotonic() < deadline_s:  # places are free again
        with connect(address) as connection:
            connection.sendall(request(address, f"{API}/events"))
            if _status(connection) == 200:
                return
        time.sleep(0.5)
    raise AssertionError("no stream can be opened any more")


def _status(connection: socket.socket) -> int:
    try:
        line = connection.recv(4096).split(b"\r\n")[0].split()
    except OSError:
        return 0
    return int(line[1]) if len(line) > 1 else 0


def test_two_editors_at_once_lose_no_edit_and_the_late_one_is_told(tmp_path):
    folder = saved_map(tmp_path / "run")
    n_each = 15

    def editor(address: str, name: str) -> tuple[int, int]:
        made = refused = 0
        with httpx.Client(base_url=address, timeout=60) as client:
            while made < n_each:
                epoch = client.get(f"{API}/instances/{CHAIR}").json()["epoch"]
                edit = {"kind": "rename", "epoch": epoch, "author": name, "instance": CHAIR, "name": f"{name} {made}"}
                response = client.post(f"{API}/edits", json=edit)
                assert response.status_code in (201, 409), response.text
                made, refused = made + (response.status_code == 201), refused + (response.status_code == 409)
        return made, refused

    # Two servers of one folder, too: what is logged is what counts.
    with server_process(folder) as (_, first), server_process(folder) as (_, second), ThreadPoolExecutor(3) as pool:
        editors = [pool.submit(editor, a, n) for a, n in ((first, "ada"), (first, "bob"), (second, "eve"))]
        done = [each.result(timeout=240) for each in editors]
        log = httpx.get(f"{second}api/v1/edits", timeout=20).json()
    assert [made for made, _ in done] == [n_each] * 3
    assert sum(refused for _, refused in done) > 0
    assert [edit["number"] for edit in log["edits"]] == list(range(1, 3 * n_each + 1))
    assert all(edit["epoch"] == edit["number"] - 1 for edit in log["edits"])
    lines = (folder / "edits.jsonl").read_text().splitlines()
    assert len([json.loads(line) for line in lines]) == 3 * n_each + 1


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_within_two_seconds_with_open_streams_and_leaves_the_folder_as_it_was(folder, number):
    before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    with server_process(folder) as (process, address), ExitStack() as stack:
        streams = [stack.enter_context(connect(address)) for _ in range(10)]
        for connection in streams:
            connection.sendall(request(address, f"{API}/events"))
            assert _status(connection) == 200
        idle, half = stack.enter_context(connect(address)), stack.enter_context(connect(address))
        half.sendall(b"GET / HT")
        assert idle
        started_s = time.monotonic()
        process.send_signal(number)
        assert process.wait(10) == 0
        assert time.monotonic() - started_s < 2
        assert process.stderr is not None
        assert process.stderr.read() == ""
    assert {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before


def test_events_reach_a_listener_in_another_process(folder):
    with server_process(folder) as (_, address), httpx.Client(base_url=address, timeout=30) as client:
        heard: list[str] = []

        def listen() -> None:
            with httpx.stream("GET", f"{address}api/v1/events", timeout=30) as response:
                for line in response.iter_lines():
                    heard.append(line)
                    if line.startswith("data"):
                        return

        listener = threading.Thread(target=listen)
        listener.start()
        while not heard:
            time.sleep(0.05)
        epoch = client.get(f"{API}/edits").json()["epoch"]
        edit = {"kind": "rename", "epoch": epoch, "author": "Ada", "instance": CHAIR, "name": "throne"}
        client.post(f"{API}/edits", json=edit)
        listener.join(10)
        client.delete(f"{API}/edits/last")
    assert "event: edit" in heard
    assert json.loads(heard[-1].removeprefix("data: ")) == {"epoch": epoch + 1, "kind": "rename", "author": "Ada"}


def test_a_taken_port_is_one_plain_line(folder, capsys):
    from tests.support.cli import razer

    with socket.create_server(("127.0.0.1", 0)) as taken:
        code, _, err = razer(capsys, "serve", folder, "--port", taken.getsockname()[1])
    assert code == 2
    assert "--port" in err
    assert len(err.strip().splitlines()) == 1


@pytest.mark.parametrize("after_s", [0.05, 0.4])
def test_it_ends_without_a_word_while_it_makes_what_is_asked_for(folder, after_s):
    with server_process(folder) as (process, address), connect(address) as connection:
        connection.sendall(request(address, f"{API}/page"))
        time.sleep(after_s)
        process.send_signal(signal.SIGINT)
        assert process.wait(10) == 0
        assert process.stderr.read() == ""
