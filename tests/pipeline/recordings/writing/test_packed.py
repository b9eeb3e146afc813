"""Packed MCAP files are those of the public writer, whatever the messages."""

from io import BytesIO

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_typestore

from tracerisk.pipeline.recordings.writing import packed
from tracerisk.pipeline.recordings.writing.cdr import DEFINITIONS, definition, log_message
from tracerisk.pipeline.recordings.writing.packed import Message, PackedWriter, Part, Series

LATER = 4


def written(times: list[int], width: int, others: list[tuple[int, bytes]]) -> bytes:
    stream = BytesIO()
    writer = PackedWriter(stream, profile="ros2", library="test")
    schema = writer.schema("std_msgs/msg/String", "ros2msg", b"string data")
    states, frames, texts = (
        writer.channel(name, "cdr", schema) for name in ("/states", "/frames", "/texts")
    )

    def numbers(begin: int, end: int, shift: int) -> np.ndarray:
        rows = np.arange(begin, end, dtype=np.int64)[:, None]
        return ((rows + np.arange(width) + shift) % 251).astype(np.uint8)

    def part(channel: int, shift: int, delay_ns: int = 0) -> Part:
        def fill(out: np.ndarray, begin: int, end: int) -> None:
            out[:, 1:] = numbers(begin, end, shift)

        return Part(channel, b"!" + bytes(width), fill, delay_ns)

    series = None
    if times:
        parts = (part(states, 0), part(frames, 7), part(states, 3, LATER))
        series = Series(np.array(times, np.int64), parts)
    # Every third one is of a channel that the series has too.
    channels = [states if number % 3 == 2 else texts for number in range(len(others))]
    messages = [
        Message(time, channel, data) for channel, (time, data) in zip(channels, others, strict=True)
    ]
    writer.messages(series, messages)
    writer.attachment(7, "it.json", "application/json", b"{}")
    writer.finish()
    return stream.getvalue()


@given(
    times=st.lists(st.integers(0, 50).map(lambda k: 2 * LATER * k), max_size=40, unique=True).map(
        sorted
    ),
    width=st.integers(1, 40),
    others=st.lists(
        st.tuples(st.integers(0, 120 * LATER), st.binary(max_size=30)), max_size=20
    ).map(lambda found: sorted(found, key=lambda each: each[0])),
    chunk=st.sampled_from([1, 100, 400, 10**6]),
)
def test_the_public_reader_gives_back_every_message_in_time(times, width, others, chunk):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(packed, "CHUNK_BYTES", chunk)
        data = written(times, width, others)
    reader = make_reader(BytesIO(data), validate_crcs=True)
    expected = sorted(
        [
            *(
                (time + delay, 0, topic, b"!" + bytes((k + j + shift) % 251 for j in range(width)))
                for k, time in enumerate(times)
                for topic, shift, delay in (
                    ("/states", 0, 0),
                    ("/frames", 7, 0),
                    ("/states", 3, LATER),
                )
            ),
            *(
                (time, 1, "/states" if number % 3 == 2 else "/texts", text)
                for number, (time, text) in enumerate(others)
            ),
        ],
        key=lambda each: each[:2],
    )
    found = [
        (message.log_time, channel.topic, message.data)
        for _, channel, message in reader.iter_messages(log_time_order=False)
    ]
    assert found == [(time, topic, text) for time, _, topic, text in expected]
    (only,) = reader.iter_attachments()
    assert (only.name, only.data) == ("it.json", b"{}")
    summary = reader.get_summary()
    assert summary.statistics.message_count == len(expected)
    by_topic = [
        (message.log_time, message.data)
        for _, _, message in reader.iter_messages(topics=["/texts"], starting_at=10)
    ]
    assert by_topic == [
        (time, text) for number, (time, text) in enumerate(others) if time >= 10 and number % 3 != 2
    ]
    of_states = [m.data for _, _, m in reader.iter_messages(topics=["/states"])]
    assert of_states == [data for _, topic, data in found if topic == "/states"]
    frames = [message.log_time for _, _, message in reader.iter_messages(topics=["/frames"])]
    assert frames == times


@pytest.mark.parametrize("name", DEFINITIONS)
def test_the_messages_that_are_written_are_those_of_ros_2(name):
    theirs = get_typestore(Stores.ROS2_JAZZY)
    assert definition(name) == theirs.generate_msgdef(name, ros_version=2)[0]


@given(time_ns=st.integers(0, 2**60), texts=st.tuples(*[st.text(max_size=9)] * 4))
def test_a_finding_is_read_back(time_ns, texts):
    data = log_message(time_ns, 30, *texts, line=7)
    store = get_typestore(Stores.ROS2_JAZZY)
    found = store.deserialize_cdr(data, "rcl_interfaces/msg/Log")
    assert (found.stamp.sec, found.stamp.nanosec) == divmod(time_ns, 10**9)
    assert (found.level, found.line) == (30, 7)
    assert (found.name, found.msg, found.file, found.function) == texts
    assert bytes(store.serialize_cdr(found, "rcl_interfaces/msg/Log")) == data
