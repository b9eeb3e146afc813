"""What a controller asks of its surroundings, and what it may command unseen, is told."""

from tests.conftest import quick_controller

_HEAVY = """

def heavy(arm):
    move = getattr(arm, "g" + "o")
    arm.set_joint_value_target([1.2, 0.4, 0, -1.5, 0, 2, 0.7])
    move()
"""


def test_what_a_run_has_not_or_has_otherwise_is_told(example):
    example.write(
        "c.py",
        quick_controller(
            "import datetime",
            "turns = int(os.environ.get('TURNS', '1'))",
            "known = 'HOME' in os.environ, os.getenv('ROS_IP'), os.environ.get('NAMED')",
            "late = datetime.date.today().year > 2026",
            "seen = any(name.startswith('trace' 'risk') for name in sys.modules)",
            "copied = dict(os.environ); os.environ['OWN'] = '1'; assert os.environ.pop('OWN')",
        ),
    )
    example.write("pyproject.toml", '[tool.tracerisk]\nenv = ["NAMED"]\n')
    ran = example.run("run", "c.py", "--json")
    assert ran.code == 0, ran.err
    told = [line for line in ran.json["assumptions"] if "something else" in line]
    assert [line.partition(":")[0] for line in told] == ["clock", "program", "environment"]
    line = quick_controller("import datetime", "TURNS").splitlines().index("    TURNS") + 1
    assert f"c.py:{line} asked for the variable TURNS, which a run does not have" in told[2]
    assert example.run("report", "c.py", "-o", "r.html").code == 0
    assert "asked for the variable TURNS" in example.read("r.html").decode()


def test_a_function_that_may_command_by_a_hidden_name_and_never_ran_is_told(example):
    source = quick_controller("if len(sys.argv) > 9: heavy(arm)")
    example.write("c.py", source.replace("\nif __name__", _HEAVY + "\n\nif __name__", 1))
    assert example.run("run", "c.py").code == 0
    checked = example.run("check", "c.py", "--verbose")
    # The other one is `home`, which commands by a name that everybody can read.
    assert "c.py: partial, 2 of 4" in checked.out
    assert "heavy can command hardware and never ran" in checked.out + checked.err
