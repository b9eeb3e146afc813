"""Words that a field may hold, by what the code and the files of its package do with it."""

import ast

import pytest

from tracerisk.errors import Location
from tracerisk.instrument.source.literals.answers import without_emergency
from tracerisk.instrument.source.literals.compared_values import compared_in_callback
from tracerisk.instrument.source.literals.named_literals import counted_names

SOURCE = """\
sub = Subscriber("/parts", Part, on_part)
srv = Service("/sort", Sort, on_sort)

def on_part(part):
    if part.confidence > 0.8:
        last[part.color] = part.pose
        log(part.data)

def on_sort(request):
    if request.color not in config["bins"]:
        return
    if request.data == "now":
        go(config.get("speeds")[request.speed])
"""


@pytest.fixture
def compared(tmp_path):
    (tmp_path / "package.xml").write_text("<package/>")
    (tmp_path / "scripts").mkdir()
    (tmp_path / "config").mkdir()
    file = tmp_path / "scripts" / "sorter.py"
    file.write_text(SOURCE)

    def compared(settings: str, line: int):
        (tmp_path / "config" / "cell.yaml").write_text(settings)
        found = compared_in_callback(Location(str(file), line))
        return found.texts(("color",)), found.texts(("speed",)), found.texts(("data",))

    return compared


CELL = "cell:\n  bins: {red: [0.1], blue: [0.2]}\n  speeds:\n    slow: 0.1\n    fast: 0.5\n"


def test_keys_of_a_mapping_in_a_file_of_the_package_are_what_is_looked_up_in_it(compared):
    assert compared(CELL, 2) == (("red", "blue"), ("slow", "fast"), ("now",))


def test_a_field_of_the_same_name_elsewhere_in_the_file_means_the_same_unless_many_have_it(
    compared,
):
    assert compared(CELL, 1) == (("red", "blue"), ("slow", "fast"), ())


def test_identity_with_a_text_is_meant_as_equality(tmp_path):
    file = tmp_path / "sorter.py"
    file.write_text(SOURCE.replace('data == "now"', 'data is "now" or request.data is None'))
    assert compared_in_callback(Location(str(file), 2)).texts(("data",)) == ("now",)


@pytest.mark.parametrize("settings", ["a: {bins: {x: 1}}\nb: {bins: {y: 1}}\n", "bins: [\n", ""])
def test_what_means_two_things_or_cannot_be_read_says_nothing(compared, settings):
    assert compared(settings, 2)[0] == ()


@pytest.mark.parametrize(
    ("source", "names"),
    [
        ('[f"joint_{i}" for i in range(1, 4)]', ("joint_1", "joint_2", "joint_3")),
        ('["j%d" % (n + 1) for n in range(2)]', ("j1", "j2")),
        ('["a{}_joint".format(n) for n in [1, 3]]', ("a1_joint", "a3_joint")),
        ('["j" + str(i) for i in range(0, 5, 2)]', ("j0", "j2", "j4")),
        ('[f"j{i:03d}" for i in range(2)]', ()),
        ('["%d%%" % i for i in range(2)]', ()),
        ("[positions[i] for i in range(2)]", ()),
        ('[f"j{i}" for i in range(n)]', ()),
        ('[f"j{i}" for i in range(2) if i]', ()),
        ('[f"j{i}" for i in range(0, 9, 0)]', ()),
    ],
)
def test_names_that_are_made_by_counting_are_known(source, names):
    assert counted_names(ast.parse(source, mode="eval").body) == names


def test_what_counts_far_gives_no_more_than_an_arm_can_have():
    assert len(counted_names(ast.parse('[f"j{i}" for i in range(10**9)]').body[0].value)) == 0
    many = ast.parse('[f"j{i}" for i in range(1000000000)]').body[0].value
    assert len(counted_names(many)) == 64


TELEOP = """\
from keys import KEYS, allows, parse
from .more import step

class Teleop:
    def start(self):
        self.create_subscription(String, "/keys", self.on_key, 10)
        self.create_subscription(State, "/state", self.on_state, 10)

    def on_key(self, message):
        event, key = parse(message.data)
        if key == "space":
            self.grip()
        delta = step(key)

    def on_state(self, message):
        self.latest = message

    def may_move(self):
        return allows(self.latest.mode, self.latest.enabled, self.latest.errors)
"""
KEYS = """\
def parse(text):
    kind, _, key = text.partition(":")
    return kind, tidy(key)

def tidy(word):
    return word.strip()

def allows(mode, enabled, errors):
    if errors != 0 or mode == 9:
        return False, "in error"
    if int(enabled) != 1:
        return False, "not enabled"
    return True, ""
"""


@pytest.fixture
def teleop(tmp_path):
    package = tmp_path / "teleop"
    package.mkdir()
    (package / "node.py").write_text(TELEOP)
    (package / "keys.py").write_text(KEYS)
    (package / "more.py").write_text(
        'def step(key):\n    steps = {"w": 1, "s": -1}\n    return steps.get(key)\n'
    )
    return lambda line: compared_in_callback(Location(str(package / "node.py"), line))


def test_what_modules_beside_the_source_compare_a_text_with_is_known(teleop):
    assert teleop(6).texts(("data",)) == ("space", "w", "s")


def test_what_is_kept_of_a_message_is_followed_into_functions_of_other_modules(teleop):
    found = teleop(7)
    assert found.numbers(("errors",)) == (0,)
    assert found.numbers(("enabled",)) == (1,)


def test_what_a_function_refuses_is_no_value_to_go_on_with(teleop):
    assert teleop(7).numbers(("mode",)) == ()


@pytest.mark.parametrize("ending", ["return False", "raise ValueError(mode)", "return (False, 1)"])
def test_each_kind_of_refusal_is_known(tmp_path, ending):
    file = tmp_path / "a.py"
    file.write_text(
        'sub = Subscriber("/m", M, on)\n'
        "def on(m):\n"
        "    if m.mode == 9:\n"
        f"        {ending}\n"
        "    if m.mode == 5:\n"
        "        go()\n"
    )
    assert compared_in_callback(Location(str(file), 1)).numbers(("mode",)) == (5,)


@pytest.mark.parametrize(
    ("test", "words"),
    [
        ('m.data in {"e", "estop"}', ("estop",)),
        ('m.data in ("!", "emergency_stop", "x")', ("emergency_stop",)),
        ('m.data in ["a", "b"]', ("a", "b")),
    ],
)
def test_what_stands_beside_a_stop_of_an_emergency_is_one_too(tmp_path, test, words):
    file = tmp_path / "a.py"
    file.write_text(f'sub = Subscriber("/m", M, on)\ndef on(m):\n    if {test}:\n        go()\n')
    assert compared_in_callback(Location(str(file), 1)).texts(("data",)) == words


def test_an_emergency_is_left_out_unless_the_code_knows_nothing_else():
    assert without_emergency(("up", "estop", "down")) == ("up", "down")
    assert without_emergency(("estop",)) == ("estop",)


@pytest.mark.parametrize(
    ("body", "texts"),
    [
        ("for word in TABLE:\n        if word in text: go(TABLE[word])", ("wave", "bow")),
        ("for word, goal in TABLE.items():\n        if word == text: go(goal)", ("wave", "bow")),
        ("if any(word in text for word in TABLE): go()", ("wave", "bow")),
        ("for goal, words in INTENTS.items():\n        if any(w in text for w in words): go(goal)",
         ("pick up", "grab", "let go")),
        ("for word, pose in [('up', 1), ('down', 2)]:\n        if word in text: go(pose)",
         ("up", "down")),
        ("for word in TABLE: log(word)\n    word = 'no'\n    if word in text: go()", ()),
    ],
)  # fmt: skip
def test_what_a_loop_goes_through_is_compared_word_by_word(tmp_path, body, texts):
    file = tmp_path / "voice.py"
    file.write_text(
        "Subscriber('/voice', String, heard)\nTABLE = {'wave': [0.1], 'bow': [0.2]}\n"
        "INTENTS = {'pick': ['pick up', 'grab'], 'drop': ('let go',)}\n"
        f"def heard(msg):\n    text = msg.data.lower()\n    {body}\n"
    )
    found = compared_in_callback(Location(str(file), 1))
    assert found.texts(("data",)) == texts
