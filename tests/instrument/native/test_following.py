"""The probe's file is read while nodes write it: by pieces, each stack named once."""

import json

from tracerisk.instrument.native.calls import Frame
from tracerisk.instrument.native.following import CallFollower

PIECE = 1 << 16


def line(name, seq, *stack, pid=7):
    entry = {"t": seq, "pid": pid, "tid": pid, "kind": "publish", "name": name, "seq": seq}
    return json.dumps({**entry, "stack": [list(frame) for frame in stack]}) + "\n"


class Written:
    """A file of pieces that processes fill, zeros behind what they have written."""

    def __init__(self, path):
        self.path, self.pieces = path, []

    def take(self):
        self.pieces.append("\n")
        return len(self.pieces) - 1

    def add(self, piece, text):
        self.pieces[piece] += text
        data = b"".join(part.encode().ljust(PIECE, b"\0") for part in self.pieces)
        self.path.write_bytes(data)


def names(calls):
    return [(call.pid, call.name, call.seq) for call in calls]


def test_each_call_comes_once_of_whichever_process_and_piece(tmp_path):
    written = Written(tmp_path / "calls.jsonl")
    follower = CallFollower(written.path)
    assert follower.new() == []
    one = written.take()
    written.add(one, line("/a", 0, ("main", "a.cpp", 3)))
    assert names(follower.new()) == [(7, "/a", 0)]
    other = written.take()
    written.add(other, line("/b", 0, ("main", "b.cpp", 4), pid=8))
    written.add(one, line("/a", 1, ("main", "a.cpp", 3)))
    assert names(follower.new()) == [(7, "/a", 1), (8, "/b", 0)]
    # The first process fills a second piece; what it began of a line is not read.
    third = written.take()
    written.add(third, line("/a", 2, ("turn", "a.cpp", 9)) + line("/a", 3)[:20])
    (call,) = follower.new()
    assert call.stack == (Frame("turn", "a.cpp", 9),)
    written.add(third, line("/a", 3)[20:])
    assert names(follower.new()) == [(7, "/a", 3)]
    assert follower.new() == []


def test_what_a_killed_process_left_and_heads_are_no_calls(tmp_path):
    written = Written(tmp_path / "calls.jsonl")
    piece = written.take()
    head = json.dumps({"probe": 1, "pid": 7, "exe": "/bin/pick"}) + "\n"
    written.add(piece, head + '{"t": 1, "pi\n' + line("/a", 0))
    follower = CallFollower(written.path)
    assert names(follower.new()) == [(7, "/a", 0)]
    assert list(follower.programs) == ["/bin/pick"]


def test_of_what_waits_no_name_is_missing(tmp_path):
    written = Written(tmp_path / "calls.jsonl")
    piece = written.take()
    modules = [["/ws/lib/libdds.so", 0, 100, 200, 5, 5]]
    written.add(piece, json.dumps({"pid": 7, "map": 1, "modules": modules}) + "\n")
    follower = CallFollower(written.path)
    for kind, notes in (("wait", 0), ("publish", 1)):
        entry = {**json.loads(line("", 0)), "kind": kind, "map": 1, "at": [150 + notes]}
        del entry["stack"]
        written.add(piece, json.dumps(entry) + "\n")
        (call,) = follower.new()
        assert call.stack == ()
        assert len(follower.notes) == notes
