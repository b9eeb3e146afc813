"""Controllers that ask `keyboard` which keys are pressed."""

import pytest

from tests.ros.keyboard.jogging import JOG

HEAD = f"import keyboard\n{JOG}"
PROGRAMS = {
    "asked": """\
while not rospy.is_shutdown():
    if keyboard.is_pressed("a"):
        jog(0.1)
    if keyboard.is_pressed("up"):
        jog(-0.1)
    if keyboard.is_pressed("q"):
        break
    rospy.sleep(0.05)
""",
    "read": """\
while True:
    event = keyboard.read_event()
    if event.event_type == keyboard.KEY_DOWN and event.name == "a":
        jog(0.1)
    elif event.event_type == keyboard.KEY_DOWN and event.name == "up":
        jog(-0.1)
    elif event.name == "q":
        break
""",
    "bound": """\
keyboard.add_hotkey("a", jog, args=(0.1,))
keyboard.on_press_key("up", lambda event: jog(-0.1))
keyboard.wait("q")
""",
}


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("kind", PROGRAMS)
def test_each_key_that_the_code_names_is_pressed(example, kind):
    example.write("keys.py", HEAD + PROGRAMS[kind])
    outcome = example.run("run", "keys.py", "--json")
    assert outcome.code == 0, outcome.err
    trace = outcome.json["trace"]
    assert trace["end"]["cause"] == "ended"
    assert {command["end"] for command in trace["commands"]} == {"arrived"}
    assert len(trace["commands"]) >= 2
    assert trace["verdict"]["kind"] == "partial"
