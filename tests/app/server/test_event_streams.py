"""Streams of events: bounded in number and in what waits, told in order, ended when they should."""

from __future__ import annotations

import asyncio
import threading

import pytest

from app.server.event_streams import MAX_WAITING, EventStreams
from app.server.problems import Refusal


def read_all(
    streams: EventStreams, n: int, while_open=lambda: None, n_events: int = 1, last: str = ""
) -> list[list[str]]:
    """What n readers of streams read, after `while_open` has been called, until each has as many texts, the latest of
    them with `last` in it; then the streams are closed."""
    told: list[list[str]] = [[] for _ in range(n)]

    async def read(response, texts: list[str]) -> None:
        async for text in response.body_iterator:
            texts.append(text)

    async def run() -> None:
        streams.start()
        readers = [asyncio.create_task(read(streams.response(), texts)) for texts in told]
        await asyncio.sleep(0)
        while_open()
        while not all(len(texts) >= n_events and last in texts[-1] for texts in told):
            await asyncio.sleep(0.001)
        streams.close()
        await asyncio.gather(*readers)

    asyncio.run(asyncio.wait_for(run(), 30))
    return told


def events(texts: list[str]) -> list[str]:
    return [text for text in texts if not text.startswith(":")]


def test_everyone_is_told_everything_in_order():
    streams = EventStreams()
    told = read_all(streams, 3, lambda: [streams.announce("edit", {"epoch": i}) for i in range(5)], 6)
    assert [events(texts) for texts in told] == [
        [f'event: edit\ndata: {{"epoch": {i}}}\n\n' for i in range(5)] for _ in range(3)
    ]


def test_events_may_come_from_any_thread():
    streams = EventStreams()

    def announce() -> None:
        threads = [threading.Thread(target=streams.announce, args=("map", {"n": i})) for i in range(20)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    told = read_all(streams, 1, announce, 21)
    assert sorted(events(told[0])) == sorted(f'event: map\ndata: {{"n": {i}}}\n\n' for i in range(20))


def test_a_slow_reader_misses_the_oldest_and_holds_up_nobody():
    streams = EventStreams()
    last = 10 * MAX_WAITING
    told = read_all(
        streams, 2, lambda: [streams.announce("map", {"n": i}) for i in range(last)], 2, f'"n": {last - 1}}}'
    )
    for texts in told:
        assert len(events(texts)) <= MAX_WAITING


def test_names_with_line_breaks_make_no_event_of_their_own():
    streams = EventStreams()
    told = read_all(streams, 1, lambda: streams.announce("edit", {"author": "x\n\nevent: map\ndata: {}"}), 2)
    assert len(events(told[0])) == 1
    assert events(told[0])[0].count("\n") == 3


def test_a_quiet_stream_has_a_heart_beat():
    streams = EventStreams(heartbeat_s=0.01)
    told = read_all(streams, 1, n_events=3)
    assert all(text.startswith(":") for text in told[0])


def test_no_more_streams_than_may_be_and_places_are_free_again():
    streams = EventStreams(max_streams=2)

    async def run() -> None:
        streams.start()
        queues = [streams.response(), streams.response()]
        with pytest.raises(Refusal, match="too many"):
            streams.response()
        streams.leave(queues[0]._queue)
        streams.response()

    asyncio.run(run())


def test_a_reader_who_leaves_before_a_word_was_sent_frees_its_place():
    streams = EventStreams(max_streams=1)

    async def run() -> None:
        streams.start()
        response = streams.response()

        async def gone():
            return {"type": "http.disconnect"}

        async def refuse(message):
            raise OSError("gone")

        with pytest.raises(BaseException):  # noqa: B017, PT011 - of what kind is the library's choice
            await response({"type": "http", "asgi": {"spec_version": "2.4"}}, gone, refuse)

    asyncio.run(run())
    assert streams.n_open == 0


def test_a_closed_house_opens_no_streams():
    streams = EventStreams()
    read_all(streams, 1)
    with pytest.raises(Refusal):
        streams.response()
