"""Controllers that listen to keys by pynput."""

import pytest

from tests.ros.keyboard.jogging import JOG

LISTENS = f"""\
from pynput import keyboard
from pynput.keyboard import Key
{JOG}def on_press(key):
    try:
        if key.char == "a":
            jog(0.1)
    except AttributeError:
        if key == Key.up:
            jog(-0.1)

def on_release(key):
    return key != keyboard.Key.esc

with keyboard.Listener(on_press=on_press, on_release=on_release) as listener:
    listener.join()
"""


def test_a_listener_hears_each_key_that_its_code_names(example):
    example.write("keys.py", LISTENS)
    outcome = example.run("run", "keys.py", "--json")
    assert outcome.code == 0, outcome.err
    trace = outcome.json["trace"]
    assert trace["end"]["cause"] == "ended"
    assert [command["end"] for command in trace["commands"]] == ["arrived", "arrived"]
    assert trace["verdict"]["kind"] == "partial"


STOPPED = """\
import rospy
from pynput import keyboard, mouse

rospy.init_node("keys")
for listener in (keyboard.Listener(on_press=print), mouse.Listener()):
    listener.start()
    rospy.sleep(0.1)
    listener.stop()
    assert not listener.running and listener.is_alive()
    listener.join()
    assert not listener.is_alive()
print("goes on")
"""


@pytest.mark.parametrize("answers", [[], ["--answer=a", "--answer=b"]])
def test_the_thread_of_a_listener_ends_once_it_is_stopped(example, answers):
    """Who waits for it goes on, whether or not a key comes."""
    example.write("keys.py", STOPPED)
    outcome = example.run("run", "keys.py", "--robot", "panda", "--no-draft", *answers)
    assert "goes on" in outcome.err
