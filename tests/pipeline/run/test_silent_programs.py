"""What a run waits for in real time and never gets ends it at the limit, and is told."""

import pytest

STARTS = "rospy.Timer(rospy.Duration(0.1), lambda event: None)"
"""What lets simulated time pass as long as nothing waits."""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("subprocess.run(['sleep', '60'])", "the end of the program sleep"),
        ("subprocess.check_output(['sleep', '60'])", "a program that it has started"),
        ("subprocess.run('sleep 60', shell=True, capture_output=True)", "an event of its loop"),
    ],
)
def test_a_program_that_never_answers_is_named_where_it_is_awaited(
    example, quick, statement, words
):
    source = quick("import subprocess", STARTS, statement)
    example.write("controller.py", source)
    outcome = example.run("run", "controller.py", "--no-draft", "--stall-limit", "1")
    assert outcome.code == 4
    place = f"controller.py:{source.splitlines().index(f'    {statement}') + 1}"
    assert f"tracerisk: {place}: MainThread waits for {words}" in outcome.err
    assert "which does not answer: nothing has moved" in outcome.err


def test_threads_that_speak_by_a_library_in_c_end_at_the_limit(example, quick):
    pytest.importorskip("zmq")
    statements = (
        "import threading, zmq",
        "context = zmq.Context()",
        "answering, asking = context.socket(zmq.REP), context.socket(zmq.REQ)",
        "port = answering.bind_to_random_port('tcp://127.0.0.1')",
        "asking.connect(f'tcp://127.0.0.1:{port}')",
        "threading.Thread(target=lambda: answering.send(answering.recv()), daemon=True).start()",
        "asking.send(b'x')",
        "asking.recv()",
    )
    source = quick(*statements)
    example.write("controller.py", source)
    outcome = example.run("run", "controller.py", "--no-draft", "--stall-limit", "1")
    assert outcome.code == 4
    # The thread that has the turn stands in the library.
    place = f"controller.py:{source.splitlines().index(f'    {statements[5]}') + 1}"
    assert f"tracerisk: {place}: nothing has moved" in outcome.err
