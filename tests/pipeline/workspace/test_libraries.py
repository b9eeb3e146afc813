"""Library code of the same repository: its functions are helpers, as an installed library's are."""

import pytest

from tracerisk.pipeline.workspace import libraries
from tracerisk.pipeline.workspace.libraries import Libraries
from tracerisk.pipeline.workspace.project import Project

LIBRARY = """\
import threading
import rospy


class Arm:
    def __init__(self, group):
        self.group = group

    def turn(self, shift):
        joints = self.group.get_current_joint_values()
        joints[0] += shift
        self._send(joints)

    def _send(self, joints):
        self.group.go(joints, wait=True)

    def turn_in_thread(self, shift):
        thread = threading.Thread(target=self.turn, args=(shift,))
        thread.start()
        thread.join()

    def turn_by(self, shift, doing):
        doing(self.group.get_current_joint_values(), shift)

    def never(self):
        self.group.go()
"""
PROGRAM = """\
#!/usr/bin/env python3
import sys
import moveit_commander, rospy
from arm_library.arm import Arm


def pick(arm):
    arm.turn(0.1)


def place(arm):
    arm.turn_in_thread(-0.1)


def wave(arm):
    def doing(joints, shift):
        joints[1] += shift
        arm.group.go(joints, wait=True)

    arm.turn_by(0.1, doing)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("program")
    group = moveit_commander.MoveGroupCommander("panda_arm")
    group.set_max_velocity_scaling_factor(1.0)
    arm = Arm(group)
    pick(arm)
    place(arm)
    wave(arm)


if __name__ == "__main__":
    main()
"""
OTHER = "#!/usr/bin/env python3\nfrom arm_library.arm import Arm\nprint(Arm)\n"
STEPS = ["pick", "place", "wave.<locals>.doing"]


def names(outcome) -> list[str]:
    return [each["ref"]["name"] for each in outcome.json["trace"]["functions"]]


def write_project(example) -> None:
    example.write("README.md", "")
    example.write("package.xml", "<package><name>demo</name></package>\n")
    example.write("scripts/program.py", PROGRAM)


@pytest.mark.slow
def test_steps_have_one_name_whether_a_library_is_installed_vendored_or_shared(
    example_in, tmp_path
):
    project = example_in(tmp_path / "project")
    write_project(project)

    def run(**environment: str):
        outcome = project.run(
            "run", "scripts/program.py", "--json", "--fresh", environment=environment
        )
        assert outcome.code == 0, outcome.err
        return outcome

    library = project.folder / "arm_library"
    project.write("arm_library/__init__.py", "")
    project.write("arm_library/arm.py", LIBRARY)
    project.write("scripts/other.py", OTHER)
    found = {"shared": run()}
    (project.folder / "scripts/other.py").unlink()
    project.write("arm_library/setup.py", "")
    found["package"] = run()
    (library / "setup.py").unlink()
    (project.folder / "vendor").mkdir()
    library.rename(project.folder / "vendor" / "arm_library")
    found["vendored"] = run()
    (project.folder / "vendor").rename(tmp_path / "site")
    found["installed"] = run(PYTHONPATH=str(tmp_path / "site"))

    for where, outcome in found.items():
        assert [state["name"] for state in outcome.json["model"]["states"]] == STEPS, where
        covered = outcome.json["trace"]["verdict"]["coverage"]
        assert covered["ran"] == covered["all"], (where, covered)
    missions = [outcome.json["assessment"]["mission"] for outcome in found.values()]
    assert all(mission == missions[0] for mission in missions)


@pytest.mark.slow
def test_a_second_program_makes_a_module_a_library_and_its_blocks_stale(example):
    write_project(example)
    example.write("arm_library/__init__.py", "")
    example.write("arm_library/arm.py", LIBRARY)
    before = example.run("run", "scripts/program.py", "--json")
    assert before.code == 0, before.err
    assert b"RiskAnnotation" in example.read("arm_library/arm.py")
    assert example.run("check", "scripts/program.py").code == 0
    example.write("scripts/other.py", OTHER)
    stale = example.run("check", "scripts/program.py")
    assert stale.code == 1
    assert "arm_library/arm.py is library code now" in stale.out + stale.err
    after = example.run("run", "scripts/program.py", "--json")
    assert after.code == 0, after.err
    assert names(after) == STEPS
    assert b"RiskAnnotation" not in example.read("arm_library/arm.py")
    assert example.run("check", "scripts/program.py").code == 0
    (example.folder / "scripts/other.py").unlink()
    stale = example.run("check", "scripts/program.py")
    assert "arm_library/arm.py is not a library code any more" in stale.out + stale.err
    risks = [
        outcome.json["assessment"]["mission"]["failure_probability"] for outcome in (before, after)
    ]
    assert risks[0] == pytest.approx(risks[1], rel=0.01)


def test_a_function_of_a_library_that_settings_name_is_a_step(example):
    write_project(example)
    example.write("arm_library/__init__.py", "")
    example.write("arm_library/arm.py", LIBRARY)
    example.write("scripts/other.py", OTHER)
    example.write("pyproject.toml", '[tool.tracerisk]\nstates = ["Arm.turn"]\n')
    outcome = example.run("run", "scripts/program.py", "--json")
    assert outcome.code == 0, outcome.err
    assert "Arm.turn" in names(outcome)


FILES = {
    "package.xml": "<package><name>demo</name></package>\n",
    "README.md": "",
    "demo/__init__.py": "",
    "demo/main.py": "from . import steps, shared\nfrom .deep.tools import grip\nimport alone\n",
    "demo/steps.py": "from demo import shared\nif __name__ == '__main__':\n    pass\n",
    "demo/shared.py": "import demo.below\n",
    "demo/below.py": "",
    "demo/deep/__init__.py": "",
    "demo/deep/tools.py": "",
    "demo/other.py": "from .shared import (\n    a,\n    b,\n)\nmain()\n",
    "demo/wider.py": "import demo.main\nimport alone\nif __name__ == '__main__':\n    pass\n",
    "alone.py": "",
    "tests/test_steps.py": "from demo.steps import x\nif __name__ == '__main__':\n    pass\n",
    "nested/package.xml": "<package><name>nested</name></package>\n",
    "nested/nested/__init__.py": "",
    "third_party/kin/__init__.py": "",
}
LIBRARIES = {
    "demo/shared.py": True,
    "demo/below.py": True,
    "alone.py": True,
    "nested/nested/__init__.py": True,
    "third_party/kin/__init__.py": True,
    "demo/main.py": False,
    # Of programs that it imports itself, that import it, and of tests.
    "demo/steps.py": False,
    "demo/deep/tools.py": False,
}


@pytest.mark.parametrize(("file", "is_library"), LIBRARIES.items())
def test_what_another_program_imports_is_library_code(example, file, is_library):
    for name, text in FILES.items():
        example.write(name, text)
    libraries = Libraries(example.folder / "demo/main.py", Project(example.folder))
    assert libraries.holds(example.folder / file) is is_library


def test_a_script_without_an_ending_and_an_installed_command_are_programs(example):
    for text, name in (("#!/usr/bin/env python3\n", "scripts/run"), ("", "demo/node.py")):
        for each, content in FILES.items():
            example.write(each, content)
        (example.folder / "demo/other.py").unlink()
        entry = "entry_points={'console_scripts': ['node = demo.node:start']}"
        example.write("setup.py", entry if name.endswith(".py") else "")
        path = example.write(name, f"{text}from demo import shared\n")
        libraries = Libraries(example.folder / "demo/main.py", Project(example.folder))
        assert libraries.holds(example.folder / "demo/shared.py"), name
        path.unlink()
        libraries = Libraries(example.folder / "demo/main.py", Project(example.folder))
        assert not libraries.holds(example.folder / "demo/shared.py"), name


@pytest.mark.slow
def test_what_no_controller_may_read_is_not_looked_at_for_programs(example):
    write_project(example)
    example.write("arm_library/__init__.py", "")
    example.write("arm_library/arm.py", LIBRARY)
    for name in (".gitignore", ".env", "id_rsa"):
        example.write(name, "")

    def refused() -> list[str]:
        found = example.run("run", "scripts/program.py", "--json", "--fresh")
        reasons = found.json["trace"]["verdict"]["reasons"]
        return [each["words"] for each in reasons if each["code"] == "access-denied"]

    assert refused() == []
    # What the controller itself reaches for is told.
    reaching = "try:\n    open('.env')\nexcept OSError:\n    pass\n"
    example.write(
        "scripts/program.py", PROGRAM.replace("\n\n\ndef pick", f"\n{reaching}\n\ndef pick")
    )
    assert [".env was not read" in each for each in refused()] == [True]


def test_a_module_of_one_program_holds_its_steps(example):
    write_project(example)
    example.write("arm_library/__init__.py", "")
    example.write("arm_library/arm.py", LIBRARY)
    outcome = example.run("run", "scripts/program.py", "--json")
    assert outcome.code == 0, outcome.err
    assert "Arm.turn_in_thread" in names(outcome)
    never = [each["ref"]["name"] for each in outcome.json["trace"]["uncovered"]]
    assert never == ["Arm.never"]


def test_a_hidden_file_is_no_program_of_the_project(example):
    for name, text in FILES.items():
        example.write(f"project/{name}", text)
    root = example.folder / "project"
    (root / ".other").write_text("#!/usr/bin/env python3\nimport demo.steps\n")
    assert not Libraries(root / "demo/main.py", Project(root)).holds(root / "demo/steps.py")


def test_links_out_of_the_project_and_sources_that_cannot_be_read_harm_nothing(example, tmp_path):
    for name, text in FILES.items():
        example.write(f"project/{name}", text)
    example.write("beyond.py", "import demo.steps\nif __name__ == '__main__':\n    pass\n")
    root = example.folder / "project"
    (root / "demo" / "linked.py").symlink_to(example.folder / "beyond.py")
    (root / "demo" / "broken.py").symlink_to(example.folder / "nowhere.py")
    example.write("project/demo/binary.py", b"\x00\xff\xfe import demo.steps")
    libraries = Libraries(root / "demo/main.py", Project(root))
    assert not libraries.holds(root / "demo/steps.py")
    assert libraries.holds(root / "demo/shared.py")


def test_each_folder_of_a_large_project_is_looked_at_once(tmp_path, monkeypatch):
    listed, read = [], []
    text_of, names_in = libraries.read_or_nothing, libraries.names_in
    monkeypatch.setattr(libraries, "names_in", lambda each: listed.append(each) or names_in(each))
    monkeypatch.setattr(
        libraries, "read_or_nothing", lambda each: read.append(each) or text_of(each)
    )
    (tmp_path / "package.xml").touch()
    package = tmp_path / "parts"
    package.mkdir()
    modules = [f"module{n}" for n in range(40)]
    for name in modules:
        imports = "".join(f"from parts.{each} import thing\n" for each in modules)
        (package / f"{name}.py").write_text(imports)
    (package / "__init__.py").touch()
    for n in range(40):
        (tmp_path / f"program{n}.py").write_text(
            f"#!/usr/bin/env python3\nimport parts.module{n}\n"
        )
    script = tmp_path / "program0.py"
    assert Libraries(script, Project(tmp_path)).holds(package / "module7.py")
    assert len(listed) == len(set(listed)) < 10
    assert max(map(read.count, read)) == 2  # whether it is a program, and what it imports
