import json

import pytest

from tracerisk.common import trace_json
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.trace_log import read_log, write_log
from tracerisk.common.traced.elements import Contact, Element, Exposure, Payload
from tracerisk.common.traced.findings import Finding
from tracerisk.common.verdict import Uncovered
from tracerisk.errors import Location, LogError
from tracerisk.trace import ObjectOffset, RunEnd, Trace, TracedFunction, Visit

PUBLISHED = """\
Function:init()
ActiveComponents:gripper,electric_motor
Function:pick_position()
ActiveComponents:electric_motor

CallSequence:init(),pick_position()
"""


def ref(name: str) -> FunctionRef:
    return FunctionRef("arm.py", QualifiedName(name))


TRACE = Trace(
    controller="arm.py",
    robot="panda",
    scene="tube_racks",
    end=RunEnd("ended", "the controller returned", 12.5),
    elements=(
        Element("j1", "joint"),
        Element("hand", "gripper", actuators=("tendon",)),
        Element("j1/encoder", "sensor", "encoder", "j1"),
    ),
    functions=(TracedFunction(ref("place"), 7, 1),),
    visits=(
        Visit(ref("place"), 0.1, 12.4, "succeeded", {"j1": Exposure(1.0, 2.0, active_s=3.0)}),
        Visit(ref("place"), 0.1, None, "aborted", {"hand": None}),
        Visit(
            ref("place"),
            0.2,
            1.0,
            "succeeded",
            {"j1": Exposure(1.0, releases=2, travel_s=0.1, wear=(0.5, 0.25, 1 / 3))},
            payloads=(Payload("hand", "tube_1", 0.025, 0.5, 12.0, 20.0),),
            contacts=(Contact("link5", "table", 0.3, 0.1, 140.0, expected=False),),
        ),
    ),
    active={"j1": Exposure(1.0, 2.0, active_s=3.0, starts=2, borderline=True)},
    uncovered=(Uncovered(ref("recover"), 40),),
    findings=(Finding("planning_failure", "out of reach", 3.25, Location("arm.py", 9)),),
    objects=(ObjectOffset("tube_1", "slot_1", 0.0004, 0.001, True),),
    assumptions=("scene: by default",),
)


def test_json_gives_back_the_trace():
    assert trace_json.loads(trace_json.dumps(TRACE), "t.json") == TRACE


def test_a_trace_from_before_actuators_had_names_is_read():
    data = json.loads(trace_json.dumps(TRACE))
    for element in data["elements"]:
        del element["actuators"]
    read = trace_json.loads(json.dumps(data), "t.json")
    assert {each.actuators for each in read.elements} == {()}
    assert read.visits == TRACE.visits


BAD_JSON = {
    '{"schema": "tracerisk-trace"': "t.json:1:29: is not valid JSON",
    "[]": "is not a trace",
    '{"schema": "tracerisk-trace", "version": 9}': "version: 9; this tracerisk reads 2",
    '{"schema": "tracerisk-trace", "version": 1}': "version: 1; this tracerisk reads 2: `tracerisk trace",
    '{"schema": "tracerisk-trace", "version": 2}': "key 'controller' is missing",
    '{"a": NaN}': "NaN is not a number",
}


@pytest.mark.parametrize(("text", "message"), BAD_JSON.items())
def test_bad_json_is_an_error_with_its_place(text, message):
    with pytest.raises(LogError) as caught:
        trace_json.loads(text, "t.json")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"robott": 1}, "unknown key 'robott'; did you mean 'robot'?"),
        ({"visits": 3}, "visits: expected a list"),
        ({"robot": 3}, "robot: expected str, found int"),
        ({"functions": []}, "visits[0].function: 'place' is not listed"),
        ({"elements": []}, "visits[0].exposures: unknown element"),
        ({"end": {"cause": "bored", "message": "", "simulated_s": 1}}, "end.cause: 'bored'"),
    ],
)
def test_wrong_shape_is_an_error_with_the_path_of_the_element(change, message):
    data = {**json.loads(trace_json.dumps(TRACE)), **change}
    with pytest.raises(LogError) as caught:
        trace_json.loads(json.dumps(data), "t.json")
    assert message in str(caught.value)


def test_published_log_is_read_as_one_visit_a_call():
    trace = read_log(PUBLISHED, "run.log", controller="arm.py")
    assert [f.ref.name for f in trace.functions] == ["init", "pick_position"]
    assert [dict(v.exposures) for v in trace.visits] == [
        {"gripper": None, "electric_motor": None},
        {"electric_motor": None},
    ]
    assert {e.kind for e in trace.elements} == {"component"}


def test_published_log_is_written_as_it_was_read():
    trace = read_log(PUBLISHED, "run.log", controller="arm.py")
    active = {v.function.name: tuple(v.exposures) for v in trace.visits}
    assert write_log(active) == PUBLISHED


def test_a_call_sequence_may_repeat():
    text = PUBLISHED.replace("init(),pick_position()", "init(),pick_position(),init()")
    trace = read_log(text, "run.log", controller="arm.py")
    assert [v.function.name for v in trace.visits] == ["init", "pick_position", "init"]
    assert [f.call_sequence for f in trace.functions] == [1, 2]


WRAPPED = """\
Function:init()
ActiveComponents:gripper,electric_motor
Function:pick_position()
ActiveComponents:electric_motor

CallSequence:init(),
pick_position()
"""


@pytest.mark.parametrize(
    "text",
    [
        WRAPPED,
        WRAPPED.replace("\n", "\r\n"),
        WRAPPED.replace(",\n", "\n , "),
        WRAPPED.replace(",\n", ",\n\n\t"),
        WRAPPED.replace("gripper,", "gripper ,\n  ").replace(":", " :\t").replace("()", " ( ) "),
        WRAPPED.replace("CallSequence:", "CallSequence:\n  "),
    ],
)
def test_a_log_may_wrap_and_space_its_lists_as_print_does(text):
    read = read_log(text, "a.log", controller="a.py")
    assert read == read_log(PUBLISHED, "a.log", controller="a.py")


BAD_LOGS = {
    WRAPPED.replace(
        ",\npick_position()", ",\npick"
    ): "run.log:7: 'pick' is not a name such as init()",
    WRAPPED.replace(",\npick_position()", ",\nunlisted()"): "run.log:7: unlisted() is called but",
    WRAPPED.replace(",\npick_position()", "\npick_position()"): "run.log:7: unknown line 'pick_p",
    WRAPPED.replace("(),\npick_position()", "(),"): "run.log:6: '' is not a name such as init()",
    "": "run.log: has no 'CallSequence:' line",
    "Functions:init()": "run.log:1: unknown line",
    "ActiveComponents:a": "run.log:1: components without a function;",
    "Function:init": "'init' is not a name such as init()",
    "Function:a(),b()": "expected one function, found 2",
    "Function:a()\nFunction:a()": "run.log:2: a() is listed twice",
    "Function:a()\nActiveComponents:x,x": "has a duplicate component",
    "Function:a()\nActiveComponents:x y": "'x y' is not a name such as electric_motor",
    "CallSequence:b()": "b() is called but has no",
    "Function:a()\nFunction:b()\nCallSequence:b()": "a() is listed but not in the call sequence",
    "Function:b()\nCallSequence:b()\nCallSequence:b()": "run.log:3: duplicate call sequence;",
}


@pytest.mark.parametrize(("text", "message"), BAD_LOGS.items())
def test_bad_log_is_an_error_with_file_and_line(text, message):
    with pytest.raises(LogError) as caught:
        read_log(text, "run.log", controller="arm.py")
    assert message in str(caught.value)


@pytest.mark.parametrize("number", ["1e400", "9" * 350, "9" * 5000, "NaN"])
def test_a_number_of_a_trace_that_no_float_holds_is_an_error(number):
    text = trace_json.dumps(TRACE).replace("12.5", number)
    with pytest.raises(LogError, match=r"^t\.json"):
        trace_json.loads(text, "t.json")
