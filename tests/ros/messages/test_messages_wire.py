"""Our bytes are those that rosbags, an implementation of its own, reads and writes."""

import io
import random
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from tests.slow import slow_but_every
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros1_base import DeserializationError, Message, copy_message
from tracerisk.ros.time.rostime import Duration, Time

INTERFACES = Interfaces()
STORED = sorted(
    name.replace("/msg/", "/")
    for name in get_typestore(Stores.ROS1_NOETIC).fielddefs
    if not name.startswith("builtin_interfaces")
)
RANGES = {
    "bool": (0, 1),
    "byte": (-128, 127),
    "int8": (-128, 127),
    "char": (0, 255),
    "uint8": (0, 255),
    "int16": (-(2**15), 2**15 - 1),
    "uint16": (0, 2**16 - 1),
    "int32": (-(2**31), 2**31 - 1),
    "uint32": (0, 2**32 - 1),
    "int64": (-(2**63), 2**63 - 1),
    "uint64": (0, 2**64 - 1),
}


def filled(kind: type[Message], rng: random.Random) -> Message:
    """A message with random values; the header's `seq`, which rosbags drops, stays 0."""
    message = kind()
    for field in kind._fields:
        if kind._type == "std_msgs/Header" and field.name == "seq":
            continue
        if field.is_array:
            count = field.length if field.length is not None else rng.randrange(3)
            values = [scalar(field, rng) for _ in range(count)]
            setattr(message, field.name, bytes(values) if field.is_bytes else values)
        else:
            setattr(message, field.name, scalar(field, rng))
    return message


def scalar(field: Any, rng: random.Random) -> Any:
    if field.message is not None:
        return filled(field.message, rng)
    if field.base == "float64":
        return rng.uniform(-1e9, 1e9)
    if field.base == "float32":
        return float(np.float32(rng.uniform(-1e3, 1e3)))
    if field.base == "string":
        return "".join(rng.choice("ab é/_") for _ in range(rng.randrange(5)))
    if field.base == "time":
        return Time(rng.randrange(2**31), rng.randrange(10**9))
    if field.base == "duration":
        return Duration(rng.randrange(2**31), rng.randrange(10**9))
    value = rng.randint(*RANGES[field.base])
    return bool(value) if field.base == "bool" else value


def to_bytes(message: Message) -> bytes:
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


@pytest.fixture(scope="module")
def store() -> Typestore:
    return get_typestore(Stores.ROS1_NOETIC)


@pytest.mark.parametrize("name", slow_but_every(4, STORED))
def test_rosbags_reads_and_writes_the_same_bytes(name, store):
    message = filled(INTERFACES.message(name), random.Random(name))
    data = to_bytes(message)
    key = name.replace("/", "/msg/")
    if name == "std_msgs/Empty":
        assert data == b""
        return
    assert bytes(store.serialize_ros1(store.deserialize_ros1(data, key), key)) == data


@pytest.mark.parametrize("name", [n for n in STORED if n != "std_msgs/Empty"])
def test_the_md5_sum_is_that_of_rosbags(name, store):
    assert INTERFACES.message(name)._md5sum == store.gendefhash(name.replace("/", "/msg/"), {})[1]


@pytest.mark.parametrize(
    "name",
    slow_but_every(
        4,
        [
            f"{package}/{name}"
            for package in ("moveit_msgs", "control_msgs", "std_msgs", "sensor_msgs")
            for name in INTERFACES.message_names(package)
        ],
    ),
)
def test_what_is_written_is_read_again(name):
    kind = INTERFACES.message(name)
    message = filled(kind, random.Random(name))
    received = kind().deserialize(to_bytes(message))
    assert received == message
    copied = copy_message(received)
    assert type(copied) is kind
    assert copied == received
    assert not mutable_parts(copied) & mutable_parts(received)


def mutable_parts(value: Any) -> set[int]:
    """Return what of a message could be changed, as the ids of these objects."""
    if isinstance(value, Message | Time | Duration):
        parts = [getattr(value, name) for name in type(value).__slots__]
    elif isinstance(value, list):
        parts = value
    else:
        return set()
    return {id(value)}.union(*map(mutable_parts, parts))


def test_a_pose_has_known_bytes():
    point = INTERFACES.message("geometry_msgs/Point")(1.0, 2.0, -1.0)
    assert to_bytes(point).hex() == "000000000000f03f" + "0000000000000040" + "000000000000f0bf"


def test_a_string_has_its_length_before_it():
    assert to_bytes(INTERFACES.message("std_msgs/String")("abc")) == b"\x03\0\0\0abc"


def test_arrays_of_numbers_are_read_as_tuples_and_bytes():
    state = INTERFACES.message("sensor_msgs/JointState")(position=[1.0, 2.0])
    assert type(state)().deserialize(to_bytes(state)).position == (1.0, 2.0)
    image = INTERFACES.message("sensor_msgs/Image")(data=[1, 2])
    assert type(image)().deserialize(to_bytes(image)).data == b"\1\2"


def test_arrays_of_numbers_are_read_as_numpy_arrays_where_asked_for():
    state = INTERFACES.message("sensor_msgs/JointState")(position=[1.0, 2.0])
    read = type(state)().deserialize_numpy(to_bytes(state), np)
    assert isinstance(read.position, np.ndarray)
    assert read.position.tolist() == [1.0, 2.0]


def test_too_few_bytes_are_an_error():
    with pytest.raises(DeserializationError):
        INTERFACES.message("std_msgs/String")().deserialize(b"\x09\0\0\0abc")
