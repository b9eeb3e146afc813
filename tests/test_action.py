"""The steps of the GitHub Action, run as the runner would, in a repository of their own."""

import json
import os
import re
import shlex
import shutil
import stat
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from tests.conftest import program
from tests.slow import slow_but

ROOT = Path(__file__).parents[1]
ACTION = ROOT / "action.yml"
EXPRESSION = re.compile(r"\$\{\{\s*(.+?)\s*\}\}")

pytestmark = pytest.mark.skipif(
    not ACTION.is_file() or shutil.which("bash") is None, reason="needs the repository and bash"
)

# GitHub's own tool, for which there is no server here: it keeps comments in a file.
GH = """\
#!{python}
import json, os, sys
from pathlib import Path

store = Path(os.environ["COMMENTS"])
comments = json.loads(store.read_text()) if store.exists() else []
arguments = sys.argv[1:]
assert arguments[0] == "api" and os.environ["GH_TOKEN"] == "secret"
if "readonly" in os.environ and "--method" in arguments:
    sys.exit("HTTP 403: Resource not accessible by integration")
if arguments[1] == "user":
    sys.exit("HTTP 403: Resource not accessible by integration")
path = next(each for each in arguments if each.startswith("repos/"))
if path.endswith("/pulls"):
    assert "head=mallory:topic" in arguments and os.environ["HEAD"]
    assert arguments[arguments.index("--method") + 1] == "GET"
    print(os.environ["FOUND"])
elif "--method" not in arguments:
    assert path == "repos/team/cell/issues/7/comments"
    wanted = arguments[arguments.index("--jq") + 1]
    assert 'select(.user.login == "github-actions[bot]" and' in wanted
    for each in comments:
        is_ours = each.get("user", "github-actions[bot]") == "github-actions[bot]"
        if is_ours and each["body"].startswith("<!-- tracerisk-diff -->"):
            print(each["id"])
else:
    method = arguments[arguments.index("--method") + 1]
    body = Path(arguments[arguments.index("--field") + 1].removeprefix("body=@")).read_text()
    if method == "POST":
        assert path == "repos/team/cell/issues/7/comments"
        comments.append({{"id": len(comments) + 1, "body": body}})
    else:
        (number,) = [int(path.rpartition("/")[2])]
        assert method == "PATCH" and path == f"repos/team/cell/issues/comments/{{number}}"
        comments[number - 1]["body"] = body
    store.write_text(json.dumps(comments))
"""


REPORTS = "https://git.example.org/team/cell/actions/runs/1/artifacts/2"


class Runner:
    """Runs the composite steps that are scripts; the steps of other actions are left out."""

    def __init__(
        self,
        folder: Path,
        repository,
        action: Path = ACTION,
        *,
        prefix: Path = Path(sys.prefix),
    ) -> None:
        """`prefix` is the environment that the tool is in."""
        self.repository = repository
        self.prefix = prefix
        self.temp = folder / "temp"
        self.comments_file = folder / "comments.json"
        self.steps = YAML(typ="safe").load(action)["runs"]["steps"]
        self.folder = action.parent
        self.inputs = {
            name: each.get("default", "")
            for name, each in YAML(typ="safe").load(action)["inputs"].items()
        }
        tools = folder / "tools"
        tools.mkdir()
        (tools / "gh").write_text(GH.format(python=sys.executable))
        (tools / "gh").chmod(stat.S_IRWXU)
        self.path = (
            f"{tools}{os.pathsep}{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        )

    def run(
        self,
        base: str,
        *,
        prefix: Path | None = None,
        around: Mapping[str, str] | None = None,
        may_fail: bool = False,
        head: str = "",
        **inputs: str,
    ) -> dict[str, str]:
        """Run every step; return the exit code of each by its id.

        The tool is that below `prefix` where it is given.
        `around` are variables of the environment that the workflow has set.
        """
        self.log = ""
        shutil.rmtree(self.temp, ignore_errors=True)
        self.temp.mkdir(parents=True)
        # As install.sh leaves it; building an environment is left to CI's own run of the README.
        folder = self.temp / "tracerisk"
        (folder / "sarif").mkdir(parents=True)
        (folder / "venv").symlink_to(prefix or self.prefix)
        values = {f"inputs.{name}": value for name, value in {**self.inputs, **inputs}.items()}
        values |= {
            "inputs.token": "secret",
            "github.action_path": str(self.folder),
            "github.event_name": "pull_request",
            "github.repository": "team/cell",
            "github.event.pull_request.base.sha": base,
            "github.event.pull_request.number": "7",
            "runner.temp": str(self.temp),
            "steps.kept.outputs.artifact-url": REPORTS,
            "github.event.workflow_run.head_repository.owner.login": "mallory",
            "github.event.workflow_run.head_branch": "topic",
            "github.event.workflow_run.head_sha": head,
        }
        codes = {}
        for step in self.steps:
            if "run" not in step or step["id"] == "install":
                continue
            values.setdefault("steps.find.outputs.number", "")
            condition = step.get("if", "")
            if "find.outputs.number" in condition and not values["steps.find.outputs.number"]:
                continue
            if "diff.outputs.code > 1" in condition and int(values["steps.diff.outputs.code"]) < 2:
                continue
            output = self.temp / f"{step['id']}.output"
            environment = {
                **os.environ,
                "PATH": self.path,
                "RUNNER_TEMP": str(self.temp),
                "GITHUB_OUTPUT": str(output),
                "COMMENTS": str(self.comments_file),
                **(around or {}),
                **{
                    name: EXPRESSION.sub(lambda found: values.get(found[1], ""), str(text))
                    for name, text in step["env"].items()
                },
            }
            outcome = subprocess.run(
                ["/bin/bash", "-euo", "pipefail", "-c", step["run"]],
                cwd=self.repository.folder / values["inputs.working-directory"],
                env=environment,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="replace",
                check=False,
            )
            self.log += outcome.stdout
            if outcome.returncode and may_fail:
                return codes
            assert outcome.returncode == 0 or step["id"] == "verdict", outcome.stdout
            codes[step["id"]] = str(outcome.returncode)
            for line in output.read_text().splitlines() if output.exists() else ():
                name, _, value = line.partition("=")
                values[f"steps.{step['id']}.outputs.{name}"] = value
        return codes

    @property
    def comments(self) -> list[str]:
        found = json.loads(self.comments_file.read_text()) if self.comments_file.exists() else []
        return [each["body"] for each in found]


@pytest.fixture
def steps(annotated_source):
    def make(gripper="= 2e-07"):
        return annotated_source(
            pick=("place 1", "motor = 2e-8 x7"),
            place=("pick 9/10, done 1/10", f"gripper {gripper}"),
        )

    return make


@pytest.fixture
def prefix(tmp_path_factory):
    """Makes an environment whose Python has a program of its own for the tool."""

    def make(tool: str) -> Path:
        folder = tmp_path_factory.mktemp("prefix")
        python = folder / "bin" / "python"
        python.parent.mkdir()
        python.write_text(
            f"""#!/bin/sh
[ "$1 $2 $3" = "-I -m tracerisk" ] || exec {sys.executable} "$@"
shift 3
{tool}
"""
        )
        python.chmod(stat.S_IRWXU)
        return folder

    return make


@pytest.fixture
def runner(tmp_path_factory, repository, steps, prefix):
    repository.write("cell.py", steps())
    repository.commit()
    warm = prefix(f'exec {shlex.join(program(os.environ))} "$@"')
    return Runner(tmp_path_factory.mktemp("runner"), repository, prefix=warm)


def commit(runner: Runner, text: str) -> str:
    base = runner.repository.git("rev-parse", "HEAD").strip()
    runner.repository.write("cell.py", text)
    runner.repository.commit()
    return base


def test_one_comment_is_written_and_kept_up_to_date(runner, steps):
    base = commit(runner, steps("= 4e-07"))
    runner.run(base, files="cell.py")
    (first,) = runner.comments
    assert first.startswith("<!-- tracerisk-diff -->\n**cell.py: mission failure rises")
    assert first.endswith(f"\n[The reports, as a download]({REPORTS})\n")
    commit(runner, steps("= 8e-07"))
    runner.run(base, files="cell.py")
    (second,) = runner.comments
    assert second != first
    assert "8e-07" in second
    commit(runner, steps())
    runner.run(base, files="cell.py")
    assert runner.comments == [
        "<!-- tracerisk-diff -->\n**No change of risk worth a comment any more.**\n"
    ]


@pytest.fixture
def ended(prefix):
    """Makes an environment whose `tracerisk diff` prints half a comment and ends as told."""

    def make(ending: str) -> Path:
        warm = shlex.join(program(os.environ))
        return prefix(
            f'[ "$1" != diff ] || {{ printf "<!-- tracerisk-diff -->\\n**cell"; {ending}; }}\n'
            f'exec {warm} "$@"'
        )

    return make


def undetermined(code: int) -> str:
    return (
        "<!-- tracerisk-diff -->\n**The change of risk could not be determined** "
        f"(exit code {code}): the log says why.\n"
        f"\n[The reports, as a download]({REPORTS})\n"
    )


@pytest.mark.parametrize(
    ("ending", "code"),
    slow_but(
        [("kill -KILL $$", 137)],  # after a code, the comment is looked at below
        [("exit 2", 2), ("exit 5", 5), ("kill -KILL $$", 137), ("exit 127", 127)],
    ),
)
def test_a_change_that_cannot_be_determined_is_never_no_change(runner, steps, ended, ending, code):
    base = commit(runner, steps("= 4e-07"))
    runner.run(base, files="cell.py")
    (first,) = runner.comments
    codes = runner.run(base, prefix=ended(ending), files="cell.py")
    assert runner.comments == [undetermined(code)]
    assert codes["verdict"] != "0"
    assert f"the change of risk could not be determined (exit code {code})" in runner.log
    runner.run(base, files="cell.py")
    assert runner.comments == [first]


def test_without_an_earlier_comment_what_cannot_be_determined_is_one(runner, steps, ended):
    base = commit(runner, steps())
    summary = runner.temp.parent / "summary.md"
    runner.run(
        base, prefix=ended("exit 5"), files="cell.py", around={"GITHUB_STEP_SUMMARY": str(summary)}
    )
    assert runner.comments == [undetermined(5)]
    assert "could not be determined" in summary.read_text()


@pytest.mark.parametrize("base", ["0" * 40, "main"])
def test_a_base_that_git_does_not_have_leaves_the_change_undetermined(runner, steps, base):
    commit(runner, steps("= 4e-07"))
    codes = runner.run(base, files="cell.py")
    (comment,) = runner.comments
    assert "could not be determined" in comment
    assert codes["verdict"] != "0"


def test_a_comparison_that_never_ran_leaves_the_change_undetermined(runner, steps):
    """As where a step before it failed: the comment is written all the same."""
    (step,) = (each for each in runner.steps if each.get("id") == "comment")
    assert "!cancelled()" in step["if"]
    runner.steps = [each for each in runner.steps if each.get("id") not in ("diff", "verdict")]
    runner.run(commit(runner, steps()), files="cell.py")
    (comment,) = runner.comments
    assert "could not be determined** (exit code unknown)" in comment


def test_a_change_that_no_reviewer_need_see_is_passed_over(runner, steps):
    base = commit(runner, steps("= 2.001e-07"))
    runner.run(base, files="cell.py")
    assert runner.comments == []


def test_alerts_and_report_are_there_though_the_verdict_is_bad(runner, steps):
    base = commit(runner, steps("= 4e-07"))
    codes = runner.run(base, files="cell.py", **{"max-increase": "0.1"})
    assert codes["verdict"] == "1"
    folder = runner.temp / "tracerisk"
    found = json.loads((folder / "sarif" / "tracerisk.sarif").read_text(encoding="utf-8"))
    rules = {each["ruleId"] for each in found["runs"][0]["results"]}
    assert rules == {"unknown-blocks", "single-point-of-failure"}
    assert "cell.py" in (folder / "report" / "cell.html").read_text(encoding="utf-8")


def test_the_report_replays_the_run_that_the_cache_holds(runner, quick):
    runner.repository.write("cell.py", quick())
    base = runner.repository.commit()
    outcome = runner.repository.run("run", "cell.py", "--quiet")
    assert outcome.code == 0, outcome.err
    runner.repository.commit()
    assert runner.run(base)["verdict"] == "0"
    page = (runner.temp / "tracerisk" / "report" / "cell.html").read_text(encoding="utf-8")
    assert 'id="replay-canvas"' in page


@pytest.mark.slow
def test_a_film_of_both_runs_is_beside_the_report_if_asked_for(runner, quick):
    runner.repository.write("cell.py", quick())
    assert runner.repository.run("run", "cell.py", "--quiet").code == 0
    base = runner.repository.commit()
    source = runner.repository.read("cell.py").decode()
    runner.repository.write("cell.py", source.replace("+= 0.05", "+= 0.25"))
    assert runner.repository.run("run", "cell.py", "--quiet").code == 0
    runner.repository.commit()
    film = runner.temp / "tracerisk" / "report" / "cell.gif"
    runner.run(base)
    assert not film.exists()
    assert runner.comments[0].endswith(f"[The reports, as a download]({REPORTS})\n")
    runner.run(base, film="true")
    if "without a screen" in runner.log:
        assert "1 films could not be made" in runner.log
        pytest.skip("nothing can be drawn here")
    assert film.read_bytes().startswith(b"GIF89a")
    link = f"[The reports, and films of the runs before and after, as a download]({REPORTS})\n"
    assert runner.comments[0].endswith(link)
    # Where a run is not kept, nothing of the checkout is run to have it.
    film.unlink()
    cache = runner.repository.folder / ".tracerisk_cache"
    for replay in cache.glob("*.replay"):
        replay.unlink()
    assert runner.run(base, film="true")["verdict"] == "0"
    assert not film.exists()
    assert not list(cache.glob("*.replay"))
    assert "no film of both runs can be made." in runner.log
    assert "::warning title=tracerisk::1 films could not be made" in runner.log


def test_the_cache_is_restored_before_anything_is_installed_and_only_if_asked_for():
    action = YAML(typ="safe").load(ACTION)
    assert action["inputs"]["replays"]["default"] == "false"
    restores = [i for i, step in enumerate(action["runs"]["steps"]) if "cache" in str(step)]
    names = [step.get("id") for step in action["runs"]["steps"]]
    assert restores[0] < names.index("install")
    step = action["runs"]["steps"][restores[0]]
    assert "inputs.replays == 'true'" in step["if"]
    assert step["with"]["path"] == "**/.tracerisk_cache"


def test_the_base_and_the_limits_are_handed_on(runner, steps, prefix, tmp_path):
    base = commit(runner, steps("= 4e-07"))
    reported = tmp_path / "told"
    noting = prefix(f'echo "$@" >>"{reported}"')
    limits = {"min-coverage": "0.8", "no-new-accepts": "false", "no-outcome-change": "true"}
    for inputs in ({}, limits):
        runner.run(base, prefix=noting, files="cell.py", comment="false", **inputs)
    lines = reported.read_text().splitlines()
    checks = [line.partition(" --sarif")[0] for line in lines if line.startswith("check")]
    diffs = [line for line in lines if line.startswith("diff")]
    assert all(line.endswith(" -- cell.py") for line in lines)
    assert checks == [
        f"check --base {base}",
        f"check --base {base} --min-coverage=0.8",
    ]
    assert ["--no-new-accepts" in line for line in diffs] == [True, False]
    assert ["--no-outcome-change" in line for line in diffs] == [False, True]


def test_expressions_stand_only_where_no_shell_reads_them():
    for step in YAML(typ="safe").load(ACTION)["runs"]["steps"]:
        assert "${{" not in step.get("run", "")


def test_a_token_that_may_not_write_costs_the_comment_alone(runner, steps):
    base = commit(runner, steps("= 4e-07"))
    codes = runner.run(base, files="cell.py", around={"readonly": "yes"})
    assert codes["comment"] == "0"
    assert runner.comments == []
    assert "::warning title=tracerisk::no comment could be written" in runner.log
    assert (runner.temp / "tracerisk" / "report" / "cell.html").is_file()
    assert "verdict" in codes


def test_a_comment_of_somebody_else_is_left_alone(runner, steps):
    theirs = {"id": 1, "body": "<!-- tracerisk-diff -->\nmine", "user": "mallory"}
    runner.comments_file.write_text(json.dumps([theirs]))
    base = commit(runner, steps("= 4e-07"))
    runner.run(base, files="cell.py")
    first, second = runner.comments
    assert first == theirs["body"]
    assert "mission failure rises" in second


def test_a_lock_that_cannot_be_read_costs_the_reports_alone(runner, steps):
    base = commit(runner, steps("= 4e-07"))
    runner.repository.write("tracerisk.lock", "{")
    runner.repository.commit()
    codes = runner.run(base)
    assert codes["report"] == "0"
    assert "of the reports could not be made" in runner.log
    assert codes["verdict"] != "0"


def test_other_actions_are_taken_by_their_digests():
    for step in YAML(typ="safe").load(ACTION)["runs"]["steps"]:
        if "uses" in step:
            assert re.fullmatch(r"[\w/-]+@[0-9a-f]{40}", step["uses"])


@pytest.fixture
def fork(runner, steps, tmp_path):
    """A pull request whose commits only the server has, and the runner of the trusted workflow."""
    ours = runner.repository
    base = ours.git("rev-parse", "HEAD").strip()
    ours.write("cell.py", steps("= 4e-07"))
    ours.write("venv.py", "raise SystemExit('a file of the fork ran')")
    ours.commit()
    head = ours.git("rev-parse", "HEAD").strip()
    server = tmp_path / "server.git"
    ours.git("clone", "--quiet", "--bare", str(ours.folder), str(server))
    ours.git("push", "--quiet", str(server), f"{head}:refs/pull/7/head", f"+{base}:refs/heads/main")
    ours.git("reset", "--quiet", "--hard", base)
    ours.git("remote", "add", "origin", str(server))
    ours.git("reflog", "expire", "--expire=now", "--all")
    ours.git("gc", "--quiet", "--prune=now")
    folder = tmp_path / "trusted"
    folder.mkdir()
    action = ROOT / "action" / "comment" / "action.yml"
    trusted = Runner(folder, ours, action, prefix=runner.prefix)

    def run(found: str = f"7 {base}"):
        return trusted.run("", head=head, around={"FOUND": found}, files="cell.py")

    return trusted, run


def test_a_pull_request_from_a_fork_is_compared_without_being_checked_out(fork):
    runner, run = fork
    run()
    (comment,) = runner.comments
    assert comment.startswith("<!-- tracerisk-diff -->\n**cell.py: mission failure rises")
    assert not (runner.repository.folder / "venv.py").exists()


def test_a_fork_whose_change_cannot_be_determined_fails_and_says_so(fork, ended):
    runner, run = fork
    assert "verdict" not in run()
    runner.prefix = ended("exit 5")
    assert run()["verdict"] == "5"
    (comment,) = runner.comments
    assert "could not be determined** (exit code 5)" in comment


@pytest.mark.parametrize("found", ["", "7 main", "7 $(touch x)", "seven " + "0" * 40])
def test_no_pull_request_gets_no_comment(fork, found):
    runner, run = fork
    codes = run(found)
    assert set(codes) == {"find"}
    assert runner.comments == []
