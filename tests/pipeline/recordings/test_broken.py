"""Broken recordings are refused with what is wrong, in bounded time."""

import contextlib
import json
import random
import shutil

import pytest

from tests.pipeline.recordings.conftest import KINDS, Mission, commanded
from tracerisk.errors import LogError, TraceRiskError
from tracerisk.pipeline.recordings.declared import Declared
from tracerisk.pipeline.recordings.measured import measured_trace

SHORT = Mission(rate_hz=20.0, seconds=5.0)


@pytest.mark.parametrize("kind", KINDS)
def test_a_recording_that_is_cut_short_is_refused(recorder, panda, kind):
    path = recorder.write(SHORT, kind, commanded())
    whole = path.read_bytes()
    for part in (0.02, 0.3, 0.7, 0.99):
        path.write_bytes(whole[: int(len(whole) * part)])
        with pytest.raises(LogError, match="damaged or was cut short"):
            measured_trace(path, panda, Declared())


@pytest.mark.parametrize("kind", KINDS)
def test_damaged_bytes_never_end_in_another_error(recorder, panda, kind):
    path = recorder.write(SHORT, kind, commanded())
    whole = path.read_bytes()
    dice = random.Random(kind)
    for _ in range(6):
        damaged = bytearray(whole)
        for _ in range(dice.choice((1, 8, 200))):
            damaged[dice.randrange(16, len(damaged))] = dice.randrange(256)
        path.write_bytes(damaged)
        # Where what is damaged is not read, it is no error.
        with contextlib.suppress(TraceRiskError):
            assert measured_trace(path, panda, Declared()).visits


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "is empty; was the recording ended?"),
        (b"time,joint\n1,2\n", "is not a recording; give an MCAP file, a bag"),
        (b"#ROSBAG V1.2\n", "damaged or was cut short"),
        (b"SQLite format 3\x00" + bytes(4096), "damaged or was cut short"),
        (None, "cannot be read: No such file"),
    ],
)
def test_what_is_no_recording_is_refused(tmp_path, panda, content, expected):
    path = tmp_path / "it.bag"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(LogError) as error:
        measured_trace(path, panda, Declared())
    assert expected in str(error.value)


def test_a_folder_is_a_recording_only_with_its_metadata(recorder, panda):
    recorder.write(SHORT, "db3", commanded())
    folder = recorder.folder / "folder of db3"
    assert measured_trace(folder, panda, Declared()).visits
    (folder / "metadata.yaml").unlink()
    with pytest.raises(LogError, match=r"is a folder without metadata\.yaml"):
        measured_trace(folder, panda, Declared())


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_a_clock_that_jumps_back_is_refused(recorder, panda, kind):
    path = recorder.write(Mission(set_back_s=3.0), kind, commanded())
    with pytest.raises(LogError, match=r"the clock of /joint_states jumps back by .* s at 2\.0"):
        measured_trace(path, panda, Declared())


def test_missing_topics_are_reported_with_those_there_are(recorder, panda):
    path = recorder.write(Mission(seconds=0.0), "mcap", commanded())
    with pytest.raises(LogError, match=r"no topic of joint states .*/tracerisk/commands"):
        measured_trace(path, panda, Declared())


def test_a_recording_with_one_joint_state_is_refused(recorder, panda):
    path = recorder.write(Mission(seconds=0.01), "mcap", commanded())
    with pytest.raises(LogError, match="joint states of panda on /joint_states of one moment only"):
        measured_trace(path, panda, Declared())


def test_a_recording_of_many_hours_is_refused(recorder, panda):
    path = recorder.write(Mission(rate_hz=0.01, seconds=5 * 3600.0), "mcap", commanded())
    with pytest.raises(LogError, match=r"5\.0 h long; at most 2 h are read"):
        measured_trace(path, panda, Declared())


def test_more_messages_than_are_read_are_refused(recorder, panda, monkeypatch):
    path = recorder.write(SHORT, "mcap", commanded())
    monkeypatch.setattr("tracerisk.pipeline.recordings.messages.MOST_MESSAGES", 50)
    with pytest.raises(LogError, match="has more than 50 messages to be read"):
        measured_trace(path, panda, Declared())


def test_positions_that_are_no_numbers_are_passed_over(recorder, panda):
    path = recorder.write(SHORT.with_(load=float("nan")), "mcap", commanded())
    trace = measured_trace(path, panda, Declared())
    json.dumps([each.torque_rms for each in trace.active.values()], allow_nan=False)


# --- by the command


@pytest.fixture
def example(tmp_path, example_in):
    return example_in(tmp_path)


def test_trace_and_field_read_recordings(example, recorder):
    names = []
    for number, late in enumerate((0.0, 0.3, 0.6)):
        made = recorder.write(Mission(seconds=9.0 + late), "bag", commanded())
        shutil.move(made, example.folder / f"mission_{number}.bag")
        names.append(f"mission_{number}.bag")
    done = example.run("trace", "--from", names[0], "--robot", "panda", "-o", "one.json")
    assert done.code == 0, done.err
    assert "pick (line 10, 1 visit)" in done.out
    assert "lost: contacts" in done.err
    assert "measured: by mission_0.bag; functions by the probe's topic" in done.err
    done = example.run("field", *names, "--robot", "panda", "-o", "field.json")
    assert done.code == 0, done.err
    found = json.loads(example.read("field.json"))
    assert (found["missions"], found["controller"]) == (3, "pick.py")
    assert set(found["functions"]) == {"pick", "place"}
    words = ("field", "one.json", *names[1:], "--robot", "panda", "--against", names[1])
    done = example.run(*words)
    assert "lies within the field's intervals" in done.out


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ((), "mission.mcap: the robot is not known; name it with --robot"),
        pytest.param(("--robot", "pandas"), "unknown robot 'pandas'", marks=pytest.mark.slow),
        (("--robot", "ur5e"), "of another robot than ur5e"),
        (("--robot", "panda", "--effort-unit", "mA"), "lacks the torque constant"),
        (("--robot", "panda", "--encoder-step", "7"), "--encoder-step: 7 is not allowed"),
        pytest.param(
            ("--robot", "panda", "--names", "/x"), "no text on /x", marks=pytest.mark.slow
        ),
        (("--robot", "panda", "--record", "x.mcap"), "--record does not go with --from"),
    ],
)
def test_what_is_missing_beside_a_recording_is_reported(example, recorder, words, expected):
    recorder.write(SHORT, "mcap", commanded())
    done = example.run("trace", "--from", "mission.mcap", *words)
    assert done.code == 2
    assert expected in done.err


def test_a_measured_trace_writes_no_block_of_python(example, recorder):
    recorder.write(SHORT, "mcap", commanded())
    example.write("pick.py", "def pick():\n    pass\n")
    words = ("trace", "pick.py", "--from", "mission.mcap", "--robot", "panda", "-o", "one.json")
    assert example.run(*words).code == 0
    done = example.run("annotate", "pick.py", "--trace", "one.json")
    assert done.code == 2
    assert "is of a real robot, and says nothing of functions that did not run" in done.err
    assert b"RiskAnnotation" not in example.read("pick.py")
