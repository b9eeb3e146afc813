"""Which packages belong to a controller's own project."""

import os
from pathlib import Path

import pytest

from tracerisk.instrument.source.literals.package_settings import package_settings
from tracerisk.pipeline.launch.parameter_files import parameter_files
from tracerisk.pipeline.workspace.prefixes import find_prefixes, installed_packages
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.workspace import Workspace, named_packages, searched
from tracerisk.ros.messages.interface_texts import InterfaceStore


def package(folder: Path) -> Path:
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(f"<package><name>{folder.name}</name></package>\n")
    return folder


def test_checkouts_beside_the_controllers_package_are_none_of_its_own(tmp_path):
    own = package(tmp_path / "downloads" / "pick_demo")
    package(tmp_path / "downloads" / "other_arm")
    package(tmp_path / "downloads" / "third" / "third_description")
    assert list(Project(own).workspace().packages) == ["pick_demo"]


def test_packages_beside_the_controllers_that_it_depends_on_are_its_own(tmp_path):
    own = package(tmp_path / "pick_demo")
    package(tmp_path / "other_arm")
    arm, base = package(tmp_path / "arm_msgs"), package(tmp_path / "more" / "base_msgs")
    (own / "package.xml").write_text(
        "<package><name>pick_demo</name><exec_depend>arm_msgs</exec_depend></package>\n"
    )
    (arm / "package.xml").write_text(
        '<package><name>arm_msgs</name><depend version_gte="1">base_msgs</depend></package>\n'
    )
    assert Project(own).workspace().packages == {
        "arm_msgs": arm,
        "base_msgs": base,
        "pick_demo": own,
    }


def test_packages_of_one_workspace_are_found_in_its_src(tmp_path):
    own = package(tmp_path / "ws" / "src" / "pick_demo")
    package(tmp_path / "ws" / "src" / "arm" / "arm_description")
    package(tmp_path / "other" / "src" / "stranger")
    assert list(Project(own).workspace().packages) == ["arm_description", "pick_demo"]


def test_a_script_in_no_package_has_the_packages_of_the_workspace_it_lies_in(tmp_path):
    arm = package(tmp_path / "ws" / "src" / "arm" / "arm_description")
    own = tmp_path / "ws" / "src" / "tools" / "scripts"
    own.mkdir(parents=True)
    assert Project(own).workspace().packages == {"arm_description": arm}
    loose = tmp_path / "program" / "src" / "tools"
    loose.mkdir(parents=True)
    assert (Project(loose).top, Project(loose).workspace().packages) == (loose, {})


@pytest.mark.parametrize("mark", ["README.md", "LICENSE", ".gitignore", "readme.rst"])
def test_packages_of_a_copied_repository_are_found_by_what_lies_at_its_top(tmp_path, mark):
    own = package(tmp_path / "repo" / "pick_demo")
    package(tmp_path / "repo" / "arm_description")
    package(tmp_path / "neighbour")
    (tmp_path / "repo" / mark).write_text("\n")
    assert list(Project(own).workspace().packages) == ["arm_description", "pick_demo"]
    assert Project(own).top == tmp_path / "repo"


def test_a_script_beside_the_src_of_a_workspace_has_its_packages(tmp_path):
    arm = tmp_path / "ws" / "src" / "arm"
    tools = tmp_path / "ws" / "tools"
    for folder in (arm, tools):
        folder.mkdir(parents=True)
    (arm / "package.xml").write_text("<package><name>arm</name></package>")
    assert Project(tools).workspace().packages == {}
    (tmp_path / "ws" / "README.md").write_text("An arm.")
    assert Project(tools).workspace().packages == {"arm": arm}


def test_a_repository_is_never_left(tmp_path):
    (tmp_path / "README.md").write_text("\n")
    own = package(tmp_path / "repo" / "pick_demo")
    package(tmp_path / "neighbour")
    (tmp_path / "repo" / ".git").mkdir()
    assert list(Project(own).workspace().packages) == ["pick_demo"]


def test_a_readme_above_src_counts_as_the_projects(tmp_path):
    own = package(tmp_path / "ws" / "src" / "pick_demo")
    (tmp_path / "ws" / "README.md").write_text("\n")
    assert Project(own).top == tmp_path / "ws"


def test_packages_beside_the_controllers_that_its_modules_import_are_its_own(tmp_path):
    own = package(tmp_path / "pick_demo")
    package(tmp_path / "other_arm")
    arm = package(tmp_path / "arm_interfaces")
    (own / "scripts").mkdir()
    (own / "scripts" / "pick.py").write_text("import os\nfrom arm_interfaces.srv import Move\n")
    assert Project(own).workspace().packages == {"arm_interfaces": arm, "pick_demo": own}


@pytest.mark.parametrize("mark", [".git", "README.md"])
def test_what_a_package_needs_of_another_repository_in_the_same_src_is_found(tmp_path, mark):
    """Several repositories are cloned into the `src` of one workspace."""
    sources = tmp_path / "ws" / "src"
    own, needed = sources / "own_repo" / "pick", sources / "arm_repo" / "arm_msgs"
    other = sources / "other_repo" / "other"
    for folder in (own, needed, other):
        folder.mkdir(parents=True)
        (folder / "package.xml").write_text(f"<package><name>{folder.name}</name></package>")
        (folder.parent / mark).mkdir()
    (own / "pick.py").write_text("from arm_msgs.srv import Move\n")
    assert Project(own).workspace().packages == {"arm_msgs": needed, "pick": own}


def repository(folder: Path, *packages: str) -> None:
    (folder / ".git").mkdir(parents=True)
    for name in packages:
        package(folder / name)


@pytest.mark.parametrize(
    ("own", "needed"),
    [
        ("src/demo_control", "arm_driver"),  # a repository that is a workspace itself
        ("demo/control", "stack/arms/arm_driver"),
        ("demos/a/control", "stack/a/arm_driver"),
    ],
)
def test_a_package_is_found_deep_in_the_src_around_a_repository(tmp_path, own, needed):
    sources = tmp_path / "ws" / "src"
    repository(sources / "own_repo", own)
    repository(sources / "other_repo", needed, "unasked")
    root = sources / "own_repo" / own
    (root / "move.py").write_text("import arm_driver\n")
    found = Project(root).workspace().packages
    assert found == {root.name: root, "arm_driver": sources / "other_repo" / needed}


@pytest.mark.parametrize("place", ["examples/python_demos", "scripts", "."])
def test_a_script_in_no_package_has_what_it_imports_of_the_repositories_beside_it(tmp_path, place):
    sources = tmp_path / "ws" / "src"
    repository(sources / "demos", "arm_control")
    repository(sources / "toolboxes", "xs_toolbox/arm_modules", "unasked")
    root = sources / "demos" / place
    root.mkdir(parents=True, exist_ok=True)
    (root / "bartender.py").write_text("from arm_modules.arm import Arm\n")
    found = Project(root).workspace().packages
    assert found["arm_modules"] == sources / "toolboxes" / "xs_toolbox" / "arm_modules"
    assert "unasked" not in found


@pytest.mark.parametrize("place", ["a/b/c/scripts", "examples/python_demos", "scripts", "."])
def test_what_is_needed_and_what_fills_in_are_of_the_same_src(tmp_path, place):
    sources = tmp_path / "ws" / "src"
    repository(sources / "demos", "arm_control")
    repository(sources / "toolboxes", "xs_toolbox/arm_modules", "unasked")
    root = sources / "demos" / place
    root.mkdir(parents=True, exist_ok=True)
    (root / "bartender.py").write_text("from arm_modules.arm import Arm\n")
    project = Project(root)
    workspace = project.workspace()
    beside = installed_packages(find_prefixes(root, project.top, 2, environment={}))
    assert workspace.packages["arm_modules"] == beside["arm_modules"]
    assert {*beside} - {*workspace.packages} == {"unasked"}


def test_files_are_listed_in_order_and_a_pipe_is_none(tmp_path):
    for name in ("b/z.py", "b/a.py", "a/c.py", ".hidden/d.py", "venv/pyvenv.cfg", "venv/e.py"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.touch()
    os.mkfifo(tmp_path / "b" / "pipe.py")
    (tmp_path / "b" / "itself.py").symlink_to("itself.py")
    (tmp_path / "b" / "link.py").symlink_to("a.py")
    found = [(Path(folder).name, files) for folder, files in searched(tmp_path, environments=False)]
    assert found == [(tmp_path.name, []), ("a", ["c.py"]), ("b", ["a.py", "link.py", "z.py"])]
    assert list(searched(tmp_path / "none")) == []


KINDS = ("launch", "config", "msg", "src", "srv")


@pytest.fixture
def vanishing(tmp_path, monkeypatch):
    """A package whose folders of the name `vanishes` go when they are about to be listed."""
    own = package(tmp_path / "pick_demo")
    for kind in KINDS:
        (own / kind / "vanishes").mkdir(parents=True)
        (own / kind / "z").mkdir()
    (own / "launch" / "z" / "pick.launch").write_text("$(find arm_msgs)")
    (own / "config" / "z" / "pick.yaml").write_text("speed: 1\n")
    (own / "msg" / "z" / "Pose.msg").touch()
    (own / "srv" / "z" / "Open.srv").write_text("---\n")
    (own / "src" / "z" / "pick.py").write_text("import arm_msgs\n")
    real = os.scandir

    def listed(folder):
        if Path(folder).name == "vanishes":
            Path(folder).rmdir()
        return real(folder)

    monkeypatch.setattr(os, "scandir", listed)
    return own


@pytest.mark.parametrize(
    "found",
    [
        lambda own: named_packages(own, {"arm_msgs": own}, ()) == {"arm_msgs"},
        lambda own: [path.name for path in parameter_files(own)] == ["pick.yaml"],
        lambda own: list(package_settings(own / "src" / "pick.py")) == ["speed"],
        lambda own: list(Workspace({"pick_demo": own}).interfaces) == ["pick_demo"],
        lambda own: InterfaceStore({"pick_demo": own}).service_names("pick_demo") == ("Open",),
    ],
)
def test_a_folder_that_is_deleted_while_it_is_looked_for_is_not_there(found, vanishing):
    assert found(vanishing)
    assert len(list(vanishing.glob("*/vanishes"))) < len(KINDS)


DEEP = {
    # what: (the package, the controller's folder), below the top of a repository
    "six folders down, beside the script": (
        "ws/src/course/submodules/wrapper/arm_msgs", "ws/src/course/submodules/wrapper/scripts"),
    "nine folders down": ("ws/src/a/b/c/d/e/f/arm_msgs", "ws/src/pick"),
    "in another branch as deep": ("ws/src/a/b/c/d/arm_msgs", "ws/src/z/y/x/w/v/scripts"),
    "far below the top, the script too": ("p/q/r/s/t/u/arm_msgs", "p/q/r/s/t/u/v/w/pick"),
}  # fmt: skip


@pytest.mark.parametrize("what", DEEP)
def test_packages_are_found_at_any_depth(what, tmp_path):
    there, here = DEEP[what]
    (tmp_path / ".git").mkdir()
    arm = package(tmp_path / there)
    own = tmp_path / here
    if own.name == "pick":
        package(own)
    else:
        own.mkdir(parents=True)
    assert Project(own).workspace().packages["arm_msgs"] == arm


@pytest.mark.parametrize("folder", [".git", "build", "node_modules", "venv"])
def test_packages_are_not_looked_for_in_what_is_no_source(folder, tmp_path):
    (tmp_path / ".git").mkdir()
    own = package(tmp_path / "pick")
    package(tmp_path / folder / "lib" / "arm_msgs")
    (tmp_path / "venv").mkdir(exist_ok=True)
    (tmp_path / "venv" / "pyvenv.cfg").touch()
    assert list(Project(own).workspace().packages) == ["pick"]


def test_a_search_that_ends_early_has_looked_around_the_controller(monkeypatch, tmp_path):
    (tmp_path / ".git").mkdir()
    for number in range(40):
        (tmp_path / "data" / f"run_{number:02}" / "frames").mkdir(parents=True)
    own, near = package(tmp_path / "z" / "y" / "pick"), package(tmp_path / "z" / "y" / "arm_msgs")
    far = package(tmp_path / "zz" / "a" / "b" / "c" / "base_msgs")
    assert Project(own).workspace().packages == {"arm_msgs": near, "base_msgs": far, "pick": own}
    monkeypatch.setattr("tracerisk.pipeline.workspace.package_folders.MOST_ENTRIES", 20)
    assert Project(own).workspace().packages == {"arm_msgs": near, "pick": own}
