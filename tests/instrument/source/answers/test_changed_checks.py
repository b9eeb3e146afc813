import textwrap

import pytest

from tracerisk.instrument.source.answers.changed_checks import changed_checks

CLIENT = """
class Cell(Node):
    def __init__(self):
        self.line = self.create_client(Move, "/arm/move")
        self.width = self.create_client(Width, "/gripper/width")

    def call(self, client, request):
        client.wait_for_service()
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result()
"""
TAKE = """
    def move(self, pose):
        return self.call(self.line, Move.Request(pose=pose))

    def take(self):
        self.move(1)
"""


def told(before, after, renamed=None):
    sources = ({"cell.py": textwrap.dedent(text).encode()} for text in (before, after))
    return [
        (check.is_lost, check.function, check.answer)
        for check in changed_checks(*sources, renamed or {})
    ]


def both_ways(before, after, function, answer):
    assert told(before, after) == [(True, function, answer)]
    assert told(after, before) == [(False, function, answer)]


def test_a_check_is_followed_through_functions_that_only_return_the_answer():
    checked = TAKE.replace(
        "self.move(1)", "if self.move(1).ret != 0:\n            raise SystemExit"
    )
    both_ways(CLIENT + checked, CLIENT + TAKE, "Cell.take", "`ret` of /arm/move")


def test_a_check_that_goes_with_its_call_is_lost():
    checked = (
        TAKE + "        if self.call(self.width, Width.Request()).data < 3:\n            raise E\n"
    )
    both_ways(CLIENT + checked, CLIENT + TAKE, "Cell.take", "`data` of /gripper/width")


def test_a_check_names_its_line():
    checked = TAKE.replace("self.move(1)", "assert self.move(1).ret == 0")
    (lost,) = changed_checks(
        {"cell.py": (CLIENT + checked).encode()}, {"cell.py": (CLIENT + TAKE).encode()}, {}
    )
    lines = (CLIENT + checked).splitlines()
    assert "assert" in lines[lost.location.line - 1]


@pytest.mark.parametrize(
    "look",
    [
        "done = self.move(1)\n        if done.ret: raise E",
        "done = self.move(1)\n        ok = done.ret == 0\n        if not ok: raise E",
        "self.judge(self.move(1).ret)",
        "self.judge_all(self.move(1))",
        "while self.move(1).ret: pass",
        "return 0 if self.move(1).ret else 1",
        "self.move(1).ret and self.stop()",
        "(done := self.move(1))\n        assert done.ret == 0",
    ],
)
def test_an_answer_that_decides_something_is_looked_at(look):
    judge = (
        "    def judge(self, code):\n        if code: raise E\n"
        "    def judge_all(self, answer):\n        if answer.ret: raise E\n"
    )
    checked = TAKE.replace("self.move(1)", look)
    function = "Cell.take"
    both_ways(CLIENT + checked + judge, CLIENT + TAKE + judge, function, "`ret` of /arm/move")


@pytest.mark.parametrize(
    "look", ["print(self.move(1).ret)", "done = self.move(1)", "self.log.info(self.move(1))"]
)
def test_an_answer_that_is_only_kept_or_printed_is_not_looked_at(look):
    assert told(CLIENT + TAKE, CLIENT + TAKE.replace("self.move(1)", look)) == []


def test_a_check_by_a_callback_is_one():
    text = """
    def move(self):
        future = self.line.call_async(1)
        future.add_done_callback(self.done)

    def done(self, future):
        if future.result().ret: raise E
    """
    without = text.replace("if future.result().ret: raise E", "pass")
    assert told(CLIENT + text, CLIENT + without) == [(True, "Cell.done", "`ret` of /arm/move")]


@pytest.mark.parametrize(
    "after",
    [
        # into the function called
        "    def move(self):\n        if self.call(self.line, 1).ret: raise E\n"
        "    def take(self):\n        self.move()\n",
        # into a new function
        "    def move(self):\n        return self.call(self.line, 1)\n"
        "    def sure(self):\n        if self.move().ret: raise E\n"
        "    def take(self):\n        self.sure()\n",
        # another name for the function and the variable
        "    def go(self):\n        return self.call(self.line, 1)\n"
        "    def take(self):\n        answer = self.go()\n        if answer.ret: raise E\n",
    ],
)
def test_a_check_that_moved_is_neither_lost_nor_new(after):
    before = (
        "    def move(self):\n        return self.call(self.line, 1)\n"
        "    def take(self):\n        if self.move().ret: raise E\n"
    )
    assert told(CLIENT + before, CLIENT + after) == []
    assert told(CLIENT + after, CLIENT + before) == []


def test_a_check_that_all_callers_took_over_is_not_lost_and_one_caller_is_not_all():
    inner = (
        "    def move(self):\n        done = self.call(self.line, 1)\n"
        "        if done.ret: raise E\n        return done\n"
    )
    plain = "    def move(self):\n        return self.call(self.line, 1)\n"
    take = "    def take(self):\n        {}\n    def put(self):\n        {}\n"
    looked, bare = "assert self.move().ret == 0", "self.move()"
    before = CLIENT + inner + take.format(bare, bare)
    assert told(before, CLIENT + plain + take.format(looked, looked)) == []
    after = CLIENT + plain + take.format(looked, bare)
    assert (True, "Cell.move", "`ret` of /arm/move") in told(before, after)


def test_one_of_several_calls_of_a_function():
    both = "def run():\n    if not arm.go(): raise E\n    if not arm.go(): raise E\n"
    one = "def run():\n    if not arm.go(): raise E\n    arm.go()\n"
    both_ways(both, one, "run", "the answer of go() in 1 of 2 calls")


def test_another_check_of_the_same_answer_does_not_stand_for_it():
    none = "def run():\n    done = arm.go()\n    if done is None: raise E\n"
    code = none + "    if done.code: raise E\n"
    both_ways(code, none, "run", "`code` of go()")
    bare = "def run():\n    done = arm.go()\n"
    both_ways(none, bare, "run", "whether go() answers at all")


def test_what_is_no_answer_of_the_cell_is_none():
    busy = (
        "import math, time\ndef run():\n    while not rospy.is_shutdown(): pass\n"
        "    if math.hypot(1, 2) > 3: pass\n    if 'a'.startswith('b'): pass\n"
        "    if len(names) > 2 and time.time() > 3: pass\n    if client.wait_for_server(): pass\n"
    )
    assert told(busy, "def run():\n    pass\n") == []


def test_a_renamed_function_keeps_its_checks():
    before = "def take():\n    assert arm.go()\n"
    after = before.replace("take", "pick_up")
    assert told(before, after, {"take": "pick_up"}) == []
    assert told(before, "def pick_up():\n    arm.go()\n", {"take": "pick_up"}) == [
        (True, "take", "the answer of go()")
    ]


RENAMED = (CLIENT + TAKE).replace("self.move(1)", "assert self.move(1).ret == 0")


@pytest.mark.parametrize(
    "was", ["/arm/griper_position", "/arm/grippr_positon", "/arm/gripperPosition"]
)
def test_a_check_of_a_service_whose_name_is_corrected_is_the_same_check(was):
    before, after = (RENAMED.replace("/arm/move", name) for name in (was, "/arm/gripper_position"))
    assert told(before, after) == []
    assert told(before, after.replace("assert self.move(1).ret == 0", "self.move(1)")) == [
        (True, "Cell.take", "`ret` of /arm/gripper_position")
    ]


@pytest.mark.parametrize(
    ("was", "now"),
    [
        ("/arm/get_position", "/arm/set_position"),
        ("/tool/attach", "/tool/detach"),
        ("/motors/activate", "/motors/deactivate"),
        ("/gripper1/move", "/gripper2/move"),
        ("/left/gripper", "/lift/gripper"),
        ("/arm/x_position", "/arm/y_position"),
    ],
)
def test_a_check_of_another_service_with_a_name_nearby_is_another(was, now):
    before, after = (RENAMED.replace("/arm/move", name) for name in (was, now))
    assert told(before, after) == [
        (True, "Cell.take", f"`ret` of {was}"),
        (False, "Cell.take", f"`ret` of {now}"),
    ]


def test_a_check_is_lost_where_both_services_were_called_before():
    """The other one is no correction: the earlier version had it too."""
    both = TAKE + "        assert self.call(self.width, 1).ret == 0\n"
    before = (
        (CLIENT + both)
        .replace("/gripper/width", "/arm/moove")
        .replace("self.move(1)", "assert self.move(1).ret == 0")
    )
    after = before.replace("assert self.call(self.width, 1).ret == 0", "pass")
    assert told(before, after) == [(True, "Cell.take", "`ret` of /arm/moove")]


def test_a_source_that_cannot_be_read_has_none():
    assert told("def (", "def run(): pass") == []


def test_a_wrapper_called_as_what_it_wraps_hands_the_answer_on():
    wrapper = "class Arm:\n    def go(self, pose):\n        return self.driver.go(pose)\n"
    plain = wrapper + "def run(arm):\n    arm.go(1)\n"
    checked = plain.replace("arm.go(1)", "assert arm.go(1)")
    both_ways(checked, plain, "run", "the answer of go()")
