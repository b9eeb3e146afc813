"""What stands beside a controller: its hardware description and its settings."""

import pytest

FAULTS = {
    "an unknown key": ("    quantity: 7\n", "    quantitty: 7\n", 3, "did you mean 'quantity'?"),
    "a missing value": ("{value: 9.5e-08, per: minute}", "{per: minute}", 4, "value"),
    "a missing probability": (
        "    probability: {value: 9.5e-08, per: minute}\n",
        "",
        2,
        "electric",
    ),
    "a probability above 1": ("9.5e-08", "1.5", 4, "1.5"),
    "a probability below 0": ("9.5e-08", "-0.5", 4, "-0.5"),
    "a probability that is not a number": ("9.5e-08", "many", 4, "many"),
    "an unknown basis": ("per: minute", "per: fortnight", 4, "allowed: "),
    "a joint that the robot lacks": (
        '"*"',
        f"[{', '.join(f'panda_joint{n}' for n in range(2, 9))}]",
        2,
        "panda_joint8",
    ),
    "a gripper's place that is none": ('{joints: "*"}', "{grippers: true}", 5, "gripper"),
    "no YAML": ("components:", "components: [", 3, "not valid YAML"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_in_the_hardware_is_reported_before_anything_is_simulated(
    name, example, quick, hardware
):
    old, new, line, message = FAULTS[name]
    assert hardware.count(old) == 1
    example.write("hardware.yaml", hardware.replace(old, new))
    example.write("controller.py", quick('open("ran", "w").close()'))
    before = example.files()
    outcome = example.run("run", "controller.py", "--hardware", "hardware.yaml", "--json")
    assert outcome.code == outcome.json["exit_code"] == 2
    assert f"tracerisk: hardware.yaml:{line}" in outcome.err
    assert message in outcome.json["error"]["message"]
    assert outcome.json["error"]["line"] == line
    assert example.files() == before, "the controller did not run"


def test_a_hardware_description_that_is_not_there_is_bad_input(example, quick):
    example.write("controller.py", quick())
    outcome = example.run("run", "controller.py", "--hardware", "nowhere.yaml")
    assert outcome.code == 2
    assert "tracerisk: nowhere.yaml: " in outcome.err


def test_settings_are_read_from_the_root_and_options_override_them(example, quick, hardware):
    example.write(
        "pyproject.toml",
        '[tool.tracerisk]\nhardware = "cell.yaml"\nactive = "moving"\nduration_s = 2\n',
    )
    example.write("cell.yaml", hardware)
    source = quick("rospy.sleep(60)")
    example.write("src/controller.py", source)
    outcome = example.run("run", "src/controller.py", "--json")
    assert outcome.code == 0, outcome.err
    end = outcome.json["trace"]["end"]
    assert (end["cause"], end["simulated_s"]) == ("duration", 2.0)
    (state,) = outcome.json["model"]["states"]
    assert list(state["probabilities"]) == ["electric_motor"]
    assert (example.folder / "tracerisk.lock").is_file(), "the lock stands at the root"
    longer = example.run("trace", "src/controller.py", "--duration", "3", "--json")
    assert longer.json["trace"]["end"]["simulated_s"] == 3.0


SETTINGS = {
    "durration_s = 2": "durration_s: unknown setting; did you mean 'duration_s'?",
    'active = "held"': "active: 'held' is not allowed; allowed: moving, moving+holding",
    "duration_s = -1": "duration_s: expected a number above 0, found -1",
    "helpers = 'home'": "helpers: expected a list of qualified names",
}


@pytest.mark.parametrize("setting", SETTINGS)
def test_a_fault_in_the_settings_is_reported_with_its_line(setting, example, quick):
    example.write("pyproject.toml", f"[project]\nname = 'cell'\n[tool.tracerisk]\n{setting}\n")
    example.write("controller.py", quick())
    before = example.files()
    outcome = example.run("run", "controller.py")
    assert outcome.code == 2
    assert "pyproject.toml:4: " in outcome.err
    assert SETTINGS[setting] in outcome.err
    assert example.files() == before


@pytest.mark.parametrize(
    ("option", "name"), [("--robot", "pandda"), ("--scene", "tube_rack"), ("--hardware", "x.yaml")]
)
def test_an_unknown_name_is_bad_input(option, name, example, quick):
    example.write("controller.py", quick('open("ran", "w").close()'))
    before = example.files()
    outcome = example.run("run", "controller.py", option, name)
    assert outcome.code == 2
    assert name in outcome.err
    assert example.files() == before


def test_descriptions_of_single_controllers_are_named_where_none_is_for_all(example, quick):
    example.write("pick.py", quick())
    example.write("hardware_panda.yaml", "components: {}\n")
    example.write(
        "pyproject.toml",
        '[tool.tracerisk.controllers."pick.py"]\nhardware = "hardware_panda.yaml"\n',
    )
    outcome = example.run("hardware", "show")
    assert outcome.code == 2
    assert "give one of hardware_panda.yaml" in outcome.err


@pytest.mark.parametrize("setting", ["hardware", "scenario"])
def test_a_fault_in_a_file_of_the_settings_names_it_as_a_user_would_type_it_here(
    example, quick, setting, monkeypatch
):
    example.write("pyproject.toml", f'[tool.tracerisk]\n{setting} = "cell.yaml"\n')
    example.write("cell.yaml", "components: 3\n" if setting == "hardware" else "objects: 3\n")
    example.write("sub/controller.py", quick("pass"))
    assert example.run("run", "sub/controller.py").err.startswith("tracerisk: cell.yaml:1:")
    monkeypatch.setattr(example, "folder", example.folder / "sub")
    outcome = example.run("run", "controller.py", "--json")
    assert outcome.err.startswith("tracerisk: ../cell.yaml:1:")
    assert outcome.json["error"]["file"] == "../cell.yaml"
