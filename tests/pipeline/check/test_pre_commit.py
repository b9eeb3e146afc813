"""The hooks of `.pre-commit-hooks.yaml`, run by pre-commit itself in a git repository."""

import itertools
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from tracerisk.pipeline.start.ci_files import template

HOOKS = YAML(typ="safe").load((Path(__file__).parents[3] / ".pre-commit-hooks.yaml").read_bytes())
BIN = Path(sys.executable).parent

HARDWARE = """\
components:
  motor: {probability: {value: 9.5e-08, per: visit}, quantity: 7, twin: {joints: "*"}}
"""
STEPS = "def home(arm):\n    arm.go()\n\n\ndef place(arm):\n    arm.go()\n"
LOG = """\
Function:home()
ActiveComponents:motor
Function:place()
ActiveComponents:motor

CallSequence:home(),place()
"""


@dataclass(frozen=True)
class Done:
    code: int
    out: str


class Repository:
    """A git repository with the hooks, taken from the hooks file for a local installation."""

    def __init__(self, folder: Path, *hooks: str) -> None:
        self.folder = folder
        home = folder.parent / "home"
        home.mkdir(exist_ok=True)
        self._environment = {
            **{name: text for name, text in os.environ.items() if not name.startswith("GIT_")},
            "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}",
            "HOME": str(home),
            "PRE_COMMIT_HOME": str(home / "pre-commit"),
            "GIT_CONFIG_NOSYSTEM": "1",
        }
        chosen = [{**hook, "language": "system"} for hook in HOOKS if hook["id"] in hooks]
        for hook in chosen:
            hook.pop("additional_dependencies", None)
        with (folder / ".pre-commit-config.yaml").open("w", encoding="utf-8") as stream:
            YAML().dump({"repos": [{"repo": "local", "hooks": chosen}]}, stream)
        self.git("init", "--quiet")
        self.git("config", "user.name", "t")
        self.git("config", "user.email", "t@example.org")

    def call(self, *command: str) -> Done:
        done = subprocess.run(
            command,
            cwd=self.folder,
            env=self._environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
            timeout=300,
        )
        return Done(done.returncode, done.stdout)

    def git(self, *arguments: str) -> str:
        done = self.call("git", *arguments)
        assert done.code == 0, done.out
        return done.out

    def hooks(self) -> Done:
        """Run the hooks on what is staged, as a commit does."""
        return self.call("pre-commit", "run")

    def commit(self) -> None:
        self.git("add", "--all")
        self.git("commit", "--quiet", "--no-verify", "--message", "x")


pytestmark = pytest.mark.skipif(
    shutil.which("pre-commit", path=str(BIN)) is None or shutil.which("git") is None,
    reason="pre-commit or git is not installed",
)


def change(path: Path, before: str, after: str) -> None:
    text = path.read_text()
    assert before in text
    path.write_text(text.replace(before, after, 1))


def annotate(example, *names: str) -> None:
    """Annotate controllers from a log, so that no simulation is needed."""
    example.write("arm.yaml", HARDWARE)
    example.write("run.log", LOG)
    for name in names:
        example.write(name, STEPS)
        outcome = example.run("annotate", name, "--log", "run.log", "--hardware", "arm.yaml", "-q")
        assert outcome.code == 0, outcome.err


@pytest.fixture
def folder(example):
    """A folder that lies a level below, so that the home of the test lies outside of it."""
    inner = type(example)(example.folder / "repository")
    inner.folder.mkdir()
    return inner


def test_the_hooks_file_says_what_pre_commit_wants():
    done = subprocess.run(
        [BIN / "pre-commit", "validate-manifest", ".pre-commit-hooks.yaml"],
        cwd=Path(__file__).parents[3],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert [(hook["id"], hook["entry"], hook["language"]) for hook in HOOKS] == [
        ("tracerisk-check", "tracerisk check", "python"),
        ("tracerisk-refresh", "tracerisk refresh", "python"),
    ]


def test_a_changed_controller_fails_the_hook_and_the_second_run_passes(folder, quick):
    example = folder
    repository = Repository(example.folder, "tracerisk-refresh", "tracerisk-check")
    example.write("my arm/quick.py", quick())
    assert example.run("run", "my arm/quick.py", "-q").code == 0
    repository.commit()
    change(example.folder / "my arm/quick.py", "+= 0.05", "+= 0.5")
    repository.git("add", "--all")
    first = repository.hooks()
    assert first.code == 1
    assert "files were modified by this hook" in first.out
    assert "quick.py: changed (my arm/quick.py has changed)" in first.out
    modified = repository.git("diff", "--name-only").splitlines()
    assert modified == ["my arm/quick.py", "tracerisk.lock"]
    repository.git("add", "--all")
    second = repository.hooks()
    assert second.code == 0, second.out
    assert second.out.count("Passed") == 2


def test_a_hand_edit_fails_and_a_pinned_one_passes_and_survives_ten_refreshes(folder):
    example = folder
    repository = Repository(example.folder, "tracerisk-check")
    annotate(example, "cell.py")
    repository.commit()
    path = example.folder / "cell.py"
    change(path, "probability = 9.5e-08", "probability = 2e-07")
    repository.git("add", "--all")
    failed = repository.hooks()
    assert failed.code == 1
    assert "exit code: 3" in failed.out
    assert (
        "cell.py:10: edited: home.motor.probability is 2e-07, was written as 9.5e-08" in failed.out
    )
    change(path, "probability = 2e-07", "probability := 2e-07  ! ; FMEA-112")
    repository.git("add", "--all")
    assert repository.hooks().code == 0
    figures = ["9.5e-08", *(f"{tenths / 10:g}e-08" for tenths in range(11, 21))]
    for before, now in itertools.pairwise(figures):
        change(example.folder / "arm.yaml", before, now)
        assert example.run("refresh", "-q").code == 0
        text = path.read_text()
        assert f"probability := 2e-07  ! computed {now}; FMEA-112" in text
        assert f"probability = {now}" in text
    repository.git("add", "--all")
    assert repository.hooks().code == 0


DIGEST = re.compile(rb"(?<=RiskAnnotation )\S+")


def digests(source: bytes) -> list[bytes]:
    return DIGEST.findall(source)


def undigested(source: bytes) -> bytes:
    return DIGEST.sub(b"", source)


def test_a_changed_hardware_description_leads_to_every_controller_that_uses_it(folder):
    example = folder
    repository = Repository(example.folder, "tracerisk-refresh")
    annotate(example, "left arm.py", "right.py", "lib/third.py")
    example.write("unrelated.py", "x = 1\n")
    repository.commit()
    before = {name: example.read(name) for name in ("left arm.py", "right.py", "lib/third.py")}
    change(example.folder / "arm.yaml", "9.5e-08", "8e-08")
    change(example.folder / "unrelated.py", "1", "2")
    repository.git("add", "--all")
    first = repository.hooks()
    assert first.code == 1
    assert first.out.count("changed (values recomputed from the cached trace)") == 3
    for name, old in before.items():
        assert digests(example.read(name)) != digests(old)
        assert undigested(example.read(name)) == undigested(old.replace(b"9.5e-08", b"8e-08"))
    repository.git("add", "--all")
    assert repository.hooks().code == 0


def test_only_what_is_staged_is_judged_and_what_is_not_stays(folder):
    example = folder
    repository = Repository(example.folder, "tracerisk-refresh", "tracerisk-check")
    annotate(example, "cell.py")
    repository.commit()
    path = example.folder / "cell.py"
    # Staged: nothing that touches the blocks. Not staged: an edit that check would not pass.
    change(path, "def home(arm):", "# The arm goes home.\ndef home(arm):")
    repository.git("add", "--all")
    change(path, "quantity = 7", "quantity = 6")
    half_staged = path.read_bytes()
    done = repository.hooks()
    assert done.code == 0, done.out
    assert path.read_bytes() == half_staged
    assert repository.git("diff", "--name-only") == "cell.py\n"


def test_where_a_refresh_meets_an_edit_that_is_not_staged_nothing_is_lost(folder):
    example = folder
    repository = Repository(example.folder, "tracerisk-refresh")
    annotate(example, "cell.py")
    repository.commit()
    path = example.folder / "cell.py"
    change(example.folder / "arm.yaml", "9.5e-08", "8e-08")
    repository.git("add", "--all")
    # The lines that the refresh rewrites, pinned by a person who has not staged them yet.
    change(path, "probability = 9.5e-08", "probability := 2e-07  ! ; FMEA-112")
    half_staged = path.read_bytes()
    lock = example.read("tracerisk.lock")
    done = repository.hooks()
    assert done.code == 1
    assert "Rolling back fixes" in done.out
    assert path.read_bytes() == half_staged
    assert example.read("tracerisk.lock") == lock
    repository.git("add", "--all")
    assert repository.hooks().code == 1
    assert re.search(r"probability := 2e-07  ! computed 8e-08; FMEA-112", path.read_text())
    repository.git("add", "--all")
    assert repository.hooks().code == 0


def test_one_controller_that_cannot_be_refreshed_keeps_no_other_from_it(folder):
    example = folder
    repository = Repository(example.folder, "tracerisk-refresh")
    annotate(example, "bad.py", "good.py")
    repository.commit()
    change(example.folder / "arm.yaml", "9.5e-08", "8e-08")
    change(example.folder / "bad.py", "    # | }\n", "")
    broken = example.read("bad.py")
    repository.git("add", "--all")
    done = repository.hooks()
    assert done.code == 1
    assert "exit code: 2" in done.out
    assert "bad.py:7: `@Component {` begins before the section of line 3 is closed" in done.out
    assert example.read("bad.py") == broken
    assert b"8e-08" in example.read("good.py")


def test_settings_lead_to_all_controllers(folder):
    example = folder
    repository = Repository(example.folder, "tracerisk-check")
    annotate(example, "cell.py")
    repository.commit()
    example.write("pyproject.toml", "[tool.tracerisk]\nmax_failure_probability = 1e-9\n")
    repository.git("add", "--all")
    done = repository.hooks()
    assert done.code == 1
    assert "above the max_failure_probability of 1e-09" in done.out


def test_a_commit_of_the_lock_alone_is_checked(folder):
    example = folder
    repository = Repository(example.folder, "tracerisk-check")
    annotate(example, "cell.py")
    repository.commit()
    change(example.folder / "tracerisk.lock", "9.5e-08", "9.6e-08")
    repository.git("add", "tracerisk.lock")
    done = repository.hooks()
    assert done.code == 1, done.out
    assert "cell.py" in done.out


def test_a_commit_of_hardware_in_sysml_alone_is_checked(folder):
    example = folder
    repository = Repository(example.folder, "tracerisk-check")
    example.write("arm.yaml", HARDWARE)
    example.write("run.log", LOG)
    example.write("cell.py", STEPS)
    assert example.run("hardware", "convert", "arm.yaml", "-o", "arm.sysml").code == 0
    outcome = example.run("annotate", "cell.py", "--log", "run.log", "--hardware", "arm.sysml")
    assert outcome.code == 0, outcome.err
    repository.commit()
    text = (example.folder / "arm.sysml").read_text()
    (example.folder / "arm.sysml").write_text(text.replace("9.5", "9.6"))
    repository.git("add", "arm.sysml")
    done = repository.hooks()
    assert done.code == 1, done.out
    assert "arm.sysml has changed" in done.out


def test_a_commit_that_deletes_a_description_is_checked(folder):
    example = folder
    repository = Repository(example.folder, "tracerisk-check")
    annotate(example, "cell.py")
    repository.commit()
    repository.git("rm", "--quiet", "arm.yaml")
    example.write("notes.md", "Unrelated.\n")
    repository.git("add", "notes.md")
    done = repository.hooks()
    assert done.code == 1, done.out
    assert "arm.yaml" in done.out


def test_the_hooks_pass_before_the_first_run(folder):
    example = folder
    repository = Repository(example.folder, "tracerisk-refresh", "tracerisk-check")
    example.write("cell.py", STEPS)
    repository.git("add", "--all")
    done = repository.hooks()
    assert done.code == 0, done.out
    assert done.out.count("Passed") == 2
    assert example.run("check").code == 2


def test_init_writes_a_hook_that_looks_at_every_commit():
    (repo,) = YAML(typ="safe").load(template("pre-commit.yaml"))["repos"]
    for hook in [*repo["hooks"], *HOOKS]:
        assert hook["always_run"] is True
        assert hook["pass_filenames"] is False
        assert not {"types", "types_or", "files", "exclude"} & hook.keys()
