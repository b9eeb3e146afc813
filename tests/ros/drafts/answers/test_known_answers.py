"""The answers that a source knows to its own question."""

import pytest

from tracerisk.errors import Location
from tracerisk.ros.drafts.answers.known_answers import known_answers
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.robots.robot import load_robot

MENUS = {
    "a number within bounds, and the word that ends the loop": (
        """
while True:
    text = input("Position: ")
    if not text:
        continue
    parts = text.split()
    if len(parts) == 1 and parts[0] == "-1":
        break
    if len(parts) != 1:
        continue
    position = float(parts[0])
    send(position)
""",
        3,
        ("0.1", "-1"),
    ),
    "what ends the loop is listed first": (
        """
while running:
    choice = input("> ")
    if choice == "0":
        running = False
    elif choice == "1":
        home()
    elif choice == "2":
        pick()
""",
        3,
        ("1", "2", "0"),
    ),
    "the items of a list in which it is looked up, under Python 2": (
        """
KEYS = ["q", "w"]
while True:
    key = raw_input()
    try:
        joint = KEYS.index(key.lower())
    except ValueError:
        continue
    turn(joint)
""",
        4,
        ("w", "q"),
    ),
    "a word behind a verb": (
        """
def move(place):
    if place not in ("BL", "TR"):
        return
    go(place)

while True:
    cmd = input("> ").strip().lower()
    if cmd == "quit":
        break
    elif cmd == "home":
        home()
    elif cmd.startswith("move "):
        where = cmd.split()[1].upper()
        move(where)
""",
        8,
        ("move BL", "move TR", "home", "quit"),
    ),
    "a function asks, another decides": (
        """
def ask():
    return input("what? ").strip().lower()

def act(word):
    if word == "home":
        home()
    elif word in ("pick", "place"):
        pick()

while True:
    said = ask()
    if said == "bye":
        sys.exit()
    act(said)
""",
        3,
        ("home", "pick", "place", "bye"),
    ),
    "a table of functions": (
        """
actions = {"o": open_hand, "c": close_hand}
while True:
    key = input("o, c or q: ")
    if key == "q":
        break
    if key in actions:
        actions[key]()
""",
        4,
        ("o", "c", "q"),
    ),
    "nothing but the printed options": (
        """
def menu():
    print("0. Quit")
    print("1. Home\\n2. Pick")
    return dispatch(int(input("Choice: ")))
""",
        5,
        ("1",),
    ),
    "a loop while the answer is another": (
        """
while (choice := input("> ")) != "done":
    if choice == "home":
        home()
""",
        2,
        ("home", "done"),
    ),
    "a loop that asks until the number is in its range": (
        """
choice = -1
while choice < 0:
    choice = int(input("Which one? "))
    if choice < 0 or choice >= len(NAMES):
        choice = -1
""",
        4,
        ("1", "-1"),
    ),
    "a measured number, or a word": (
        """
while steps:
    text = input("Force in N, or r to redo: ").strip().lower()
    if text == "q":
        break
    if text == "r":
        continue
    try:
        force = float(text)
    except ValueError as error:
        raise RuntimeError(f"no force: {text!r}") from error
""",
        3,
        ("0.5", "r", "q"),
    ),
    "a whole number, or a word": (
        """
while True:
    text = input("Which cell (or 'home')? ")
    if text == "home":
        home()
    else:
        go_to(int(text))
""",
        3,
        ("1", "home"),
    ),
    "a number of a menu stays the menu's": (
        """
while True:
    choice = input("Choice (q to quit): ")
    if choice == "q":
        break
    if int(choice) == 3:
        home()
""",
        3,
        ("3", "q"),
    ),
    "printed options alone": (
        """
def menu():
    print("[q] leave")
    print("[h] go home")
    return input("Choice: ")
dispatch(menu())
""",
        5,
        ("h", "q"),
    ),
}  # fmt: skip


@pytest.mark.parametrize(("source", "line", "answers"), MENUS.values(), ids=MENUS)
def test_a_menu_is_answered_with_what_moves_and_then_with_what_ends_it(
    tmp_path, source, line, answers
):
    file = tmp_path / "menu.py"
    file.write_text(source)
    pose = Pose((0.4, 0.0, 0.3), (1.0, 0.0, 0.0, 0.0))
    values = UsableValues(load_robot("panda"), lambda *_: pose, lambda *_: {})
    assert known_answers(Location(str(file), line), values).in_turn == answers
