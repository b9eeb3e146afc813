"""What a controller imports of its own is found, and speaks for its robot, without running it."""

from pathlib import Path

from tracerisk import api
from tracerisk.config import Settings
from tracerisk.pipeline.robot.choice import choose_robot
from tracerisk.pipeline.workspace.own_modules import own_modules, with_own_modules

FILES = {
    "package.xml": "<package><name>cell</name></package>\n",
    "scripts/start.py": "import rospy\nfrom cell import node\nnode.main()\n",
    "src/cell/__init__.py": "",
    "src/cell/node.py": "from . import names\nfrom .arms.left import GROUP\n\n\ndef main(): ...\n",
    "src/cell/names.py": 'JOINTS = ["panda_joint1", "panda_joint2"]\n',
    "src/cell/arms/__init__.py": "",
    "src/cell/arms/left.py": 'GROUP = "panda_arm"\n',
    "src/cell/unused.py": 'JOINTS = ["right_j0", "right_j1", "right_j2", "right_j3"]\n',
}


def written(top: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        path = top / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return top / "scripts" / "start.py"


def names(script: Path) -> list[str]:
    controller = api.load_controller(script)
    top = script.parents[1]
    return sorted(path.relative_to(top).as_posix() for path in own_modules(controller))


def test_modules_are_followed_through_packages_and_relative_imports(tmp_path):
    script = written(tmp_path, FILES)
    assert names(script) == [
        "src/cell/__init__.py", "src/cell/arms/__init__.py", "src/cell/arms/left.py",
        "src/cell/names.py", "src/cell/node.py",
    ]  # fmt: skip


def test_a_module_that_imports_its_importer_and_one_that_is_no_python_end_the_search(tmp_path):
    files = {
        **FILES,
        "src/cell/names.py": "import start\nfrom cell import node, broken\n",
        "src/cell/broken.py": "print = = 'old'\nimport cell.unused\n",
    }
    script = written(tmp_path, files)
    assert "src/cell/broken.py" in names(script)
    assert "src/cell/unused.py" not in names(script)
    assert b"print = = 'old'" not in with_own_modules(api.load_controller(script)).source


def test_the_names_in_its_modules_say_the_robot(tmp_path):
    script = written(tmp_path, FILES)
    robot = choose_robot(api.load_controller(script), Settings()).robot
    assert robot.name == "panda"
    lists = 'JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"]\n'
    (tmp_path / "src/cell/names.py").write_text(lists)
    (tmp_path / "src/cell/arms/left.py").write_text('GROUP = "ur10e"\n')
    robot = choose_robot(api.load_controller(script), Settings()).robot
    assert robot.name == "ur10e"


def test_a_module_in_another_encoding_is_read_in_its_own(tmp_path):
    script = written(tmp_path, FILES)
    text = '# coding: latin-1\nJOINTS = ["panda_joint1"]  # Gelenk, grün\n'
    (tmp_path / "src/cell/names.py").write_bytes(text.encode("latin-1"))
    assert "grün" in with_own_modules(api.load_controller(script)).source.decode()
