"""Controllers that read keys from a screen of curses."""

import pytest

from tests.ros.keyboard.jogging import JOG
from tracerisk.errors import Location
from tracerisk.instrument.source.literals.known_keys import known_keys

SCREEN = f"""\
import curses
{JOG}def main(screen):
    curses.curs_set(0)
    screen.nodelay(WAITS)
    curses.init_pair(1, curses.COLOR_RED, curses.COLOR_BLACK)
    screen.addstr(0, 0, "arrows move", curses.color_pair(1) | curses.A_BOLD)
    while True:
        key = screen.getch()
        if key == curses.KEY_LEFT:
            jog(0.1)
        elif key == ord("d"):
            jog(-0.1)
        elif key == 27:
            return
        rospy.sleep(0.05)

curses.wrapper(main)
"""


@pytest.mark.parametrize("is_polled", [True, False])
def test_a_screen_without_a_terminal_gets_each_key_that_its_code_names(example, is_polled):
    example.write("keys.py", SCREEN.replace("WAITS", str(is_polled)))
    outcome = example.run("run", "keys.py", "--json")
    assert outcome.code == 0, outcome.err
    trace = outcome.json["trace"]
    assert trace["end"]["cause"] == "ended"
    assert [command["end"] for command in trace["commands"]] == ["arrived", "arrived"]
    assert trace["verdict"]["kind"] == "partial"


def test_keys_of_curses_and_of_libraries_are_known_by_their_names(tmp_path):
    source = tmp_path / "keys.py"
    source.write_text(
        "if key == curses.KEY_UP: pass\n"
        "elif key in (ord('w'), 10): pass\n"
        "elif key == Key.page_down: pass\n"
        "elif key.char == 's' or k.lower() == 'space': pass\n"
        "elif key == KeyCode.from_char('e'): pass\n"
        "elif count == 65: pass\n"
        "moves = {curses.KEY_LEFT: 1, ord('k'): -1}\n"
        "if pygame.key.get_pressed()[pygame.K_m]: pass\n"
    )
    wanted = ("\x1b[A", "w", "\n", "\x1b[6~", "s", " ", "e", "\x1b[D", "k", "m")
    assert known_keys(Location(str(source), 1)) == wanted


PACED = """\
import curses
import rospy

rospy.init_node("keys")

def main(screen):
    began = rospy.get_time()
    curses.napms(1500)
    print("napped", round(rospy.get_time() - began, 2))
    curses.halfdelay(5)
    for _ in range(3):
        assert screen.getch() in (-1, ord("w"))
    print("looked", round(rospy.get_time() - began, 2))

curses.wrapper(main)
"""


def test_a_nap_and_a_look_for_a_key_with_an_end_take_their_time(example):
    """Who paces its commands by them would else command all at once."""
    example.write("keys.py", PACED)
    outcome = example.run("run", "keys.py", "--robot", "panda", "--no-draft")
    assert "napped 1.5" in outcome.err
    assert "looked 3.0" in outcome.err


def test_a_run_that_reads_no_keys_needs_no_curses(example, quick):
    """It is a module of a library of C, which a Python may be built without."""
    loaded = "print('curses' in sys.modules, '_curses' in sys.modules)"
    example.write("c.py", quick("import sys", loaded))
    outcome = example.run("run", "c.py")
    assert outcome.code == 0, outcome.err
    assert "False False" in outcome.err
