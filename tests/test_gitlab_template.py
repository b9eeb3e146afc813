"""The script of the GitLab job, run as its runner would, with a server of notes on loopback."""

import json
import os
import re
import shutil
import subprocess
import sys
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from urllib.parse import parse_qs

import pytest
from ruamel.yaml import YAML

from tracerisk.adder.lock.lock import ControllerLock, Lock, written_block
from tracerisk.adder.sources.read import read_blocks

ROOT = Path(__file__).parents[1]
TEMPLATE = ROOT / "tracerisk" / "pipeline" / "start" / "templates" / "gitlab.yaml"
NOTES = "/api/v4/projects/3/merge_requests/7/notes"

pytestmark = pytest.mark.skipif(
    not TEMPLATE.is_file() or shutil.which("curl") is None, reason="needs the repository and curl"
)


class Server(HTTPServer):
    """Keeps the notes of one merge request."""

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.notes: list[str] = ["looks good"]
        self.first_author = 4


class Handler(BaseHTTPRequestHandler):
    server: Server

    def answer(self, data: object) -> None:
        self.send_response(200)
        self.end_headers()
        self.wfile.write(json.dumps(data).encode())

    def body(self) -> str:
        assert self.headers["PRIVATE-TOKEN"] == "secret"
        text = self.rfile.read(int(self.headers["Content-Length"])).decode()
        return parse_qs(text)["body"][0]

    def do_GET(self) -> None:
        assert self.headers["PRIVATE-TOKEN"] == "secret"
        if self.path == "/api/v4/user":
            self.answer({"id": 5})
            return
        assert self.path.partition("?")[0] == NOTES
        authors = [self.server.first_author, *[5] * len(self.server.notes)]
        self.answer(
            [
                {"id": i, "body": body, "author": {"id": author}}
                for i, (body, author) in enumerate(zip(self.server.notes, authors, strict=False))
            ]
        )

    def do_POST(self) -> None:
        assert self.path == NOTES
        self.server.notes.append(self.body())
        self.answer({})

    def do_PUT(self) -> None:
        self.server.notes[int(self.path.removeprefix(f"{NOTES}/"))] = self.body()
        self.answer({})

    def log_message(self, *arguments: object) -> None:
        pass


@pytest.fixture
def server():
    with Server() as found:
        thread = threading.Thread(target=found.serve_forever, daemon=True)
        thread.start()
        yield found
        found.shutdown()
        thread.join()


@pytest.fixture
def job(repository, server):
    read = YAML(typ="safe").load(TEMPLATE)["tracerisk"]
    (script,) = read["script"]

    def run(base: str, token: str = "secret", **more: str) -> int:
        environment = {
            **os.environ,
            **read["variables"],
            "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
            "CI_API_V4_URL": f"http://127.0.0.1:{server.server_port}/api/v4",
            "CI_PROJECT_ID": "3",
            "CI_MERGE_REQUEST_IID": "7",
            "CI_MERGE_REQUEST_DIFF_BASE_SHA": base,
            "TRACERISK_TOKEN": token,
            **more,
        }
        return subprocess.run(
            ["/bin/sh", "-c", script], cwd=repository.folder, env=environment, check=False
        ).returncode

    return run


def test_one_note_is_kept_up_to_date(repository, annotated_source, server, job):
    def commit(gripper):
        repository.write("cell.py", annotated_source(place=("done 1", f"gripper = {gripper}")))
        repository.write(
            "tracerisk.lock", '{"schema": "tracerisk.lock", "version": 1, "controllers": {}}'
        )
        return repository.commit()

    base = commit("2e-07")
    commit("4e-07")
    # The lock of this repository knows no controller: bad input, told last.
    assert job(base) == 2
    assert len(server.notes) == 2
    assert server.notes[1].startswith("<!-- tracerisk-diff -->\n**cell.py: mission failure rises")
    commit("8e-07")
    job(base)
    assert len(server.notes) == 2
    assert "8e-07" in server.notes[1]
    commit("2e-07")
    job(base)
    assert server.notes[1].endswith("**No change of risk worth a comment any more.**\n")


def test_a_target_branch_that_moved_on_is_said(repository, annotated_source, job):
    def commit(figure):
        repository.write("cell.py", annotated_source(place=("done 1", f"gripper = {figure}")))
        return repository.commit()

    base = commit("2e-07")
    repository.git("branch", "change")
    later = commit("3e-07")
    repository.git("update-ref", "refs/remotes/origin/main", later)
    repository.git("checkout", "-q", "change")
    commit("4e-07")
    job(base, token="", CI_MERGE_REQUEST_TARGET_BRANCH_NAME="main")
    said = repository.read("tracerisk.md").decode()
    assert "origin/main has moved on since" in said
    job(base, token="", CI_MERGE_REQUEST_TARGET_BRANCH_NAME="gone")
    said = repository.read("tracerisk.md").decode()
    assert "moved on" not in said
    assert "mission failure rises" in said


@pytest.mark.parametrize(("base", "code"), [("HEAD~1", 2), ("0" * 40, 2)])
def test_a_change_that_cannot_be_determined_is_never_no_change(
    repository, annotated_source, server, job, base, code
):
    repository.write("cell.py", annotated_source(place=("done 1", "gripper = 2e-07")))
    repository.commit()
    repository.write("cell.py", annotated_source(place=("gone 1", "gripper = 2e-07")))
    repository.commit()
    server.notes.append("<!-- tracerisk-diff -->\n**an earlier note**")
    assert job(base) == code
    assert server.notes[1:] == [
        "<!-- tracerisk-diff -->\n**The change of risk could not be determined** "
        f"(exit code {code}): the log says why.\n"
    ]
    assert "could not be determined" in repository.read("tracerisk.md").decode()


def test_no_token_writes_no_note(repository, annotated_source, server, job):
    repository.write("cell.py", annotated_source(place=("done 1", "gripper = 2e-07")))
    base = repository.commit()
    repository.write("cell.py", annotated_source(place=("done 1", "gripper = 4e-07")))
    repository.commit()
    job(base, token="")
    assert server.notes == ["looks good"]
    assert "mission failure rises" in repository.read("tracerisk.md").decode()


@pytest.mark.parametrize(
    ("variables", "check", "diff"),
    [
        ({}, "", "--no-new-accepts --no-weaker-checks --silent-below=0.01"),
        (
            {"TRACERISK_NO_OUTCOME_CHANGE": "true", "TRACERISK_SILENT_BELOW": ""},
            "",
            "--no-new-accepts --no-weaker-checks --no-outcome-change",
        ),
        (
            {
                "TRACERISK_MAX_INCREASE": "0.1",
                "TRACERISK_MAX_FAILURE_PROBABILITY": "1e-3",
                "TRACERISK_MIN_COVERAGE": "0.8",
                "TRACERISK_NO_NEW_ACCEPTS": "false",
            },
            " --min-coverage=0.8",
            "--max-increase=0.1 --max-failure-probability=1e-3 --no-weaker-checks "
            "--silent-below=0.01",
        ),
    ],
)
def test_the_limits_are_handed_on(repository, job, tmp_path, variables, check, diff):
    told = tmp_path / "told"
    python = tmp_path / "bin" / "python"
    python.parent.mkdir()
    python.write_text(f"""#!/bin/sh
shift 3
echo "$@" >>"{told}"
[ "$1" != diff ] || exit 1
""")
    python.chmod(0o700)
    path = f"{python.parent}{os.pathsep}{os.environ['PATH']}"
    assert job("base", token="", PATH=path, **variables) == 1
    checked, compared, *_ = told.read_text().splitlines()
    files = r"--sarif \S+ --code-quality \S+ --metrics \S+"
    assert re.fullmatch(f"check --base base {files}{re.escape(check)}", checked)
    assert re.sub(r"--code-quality \S+/diff\.json ", "", compared) == (
        f"diff --format markdown {diff} base..HEAD"
    )


def test_the_job_runs_in_merge_requests_and_on_the_default_branch():
    read = YAML(typ="safe").load(TEMPLATE)["tracerisk"]
    assert read["rules"] == [
        {"if": '$CI_PIPELINE_SOURCE == "merge_request_event"'},
        {"if": "$CI_COMMIT_BRANCH == $CI_DEFAULT_BRANCH"},
    ]


@pytest.mark.slow
def test_each_controller_has_its_report_with_the_replay_of_the_cache(repository, job, quick):
    repository.write("cell/arm.py", quick())
    repository.write("cell/pyproject.toml", "")
    base = repository.commit()
    outcome = repository.run("run", "cell/arm.py", "--quiet")
    assert outcome.code == 0, outcome.err
    repository.commit()
    assert job(base, token="") == 0
    page = repository.read("tracerisk-report/cell-arm.html").decode()
    assert 'id="replay-canvas"' in page
    assert 'id="difference"' in page


def test_code_quality_and_metrics_are_artefacts_of_both_pipelines(
    repository, annotated_source, server, job
):
    def commit(redundancy):
        text = annotated_source(place=("done 1", f"gripper = 2e-07 {redundancy}"))
        blocks = {
            "cell.py": {
                placed.function: written_block(placed.block)
                for placed in read_blocks(text.encode(), "cell.py")
            }
        }
        lock = Lock().with_controller("cell.py", ControllerLock("f", blocks))
        repository.write("cell.py", text)
        repository.write("tracerisk.lock", lock.dumps())
        return repository.commit()

    base = commit("of2")
    commit("x2")
    job(base)
    found = json.loads(repository.read("tracerisk-quality.json"))
    assert {entry["check_name"] for entry in found} >= {"lost-redundancy", "stale-block"}
    fingerprints = [entry["fingerprint"] for entry in found]
    assert len(set(fingerprints)) == len(fingerprints)
    assert {entry["location"]["path"] for entry in found} == {"cell.py"}
    assert {entry["severity"] for entry in found} <= {"info", "minor", "major"}
    metrics = repository.read("tracerisk-metrics.txt").decode()
    assert 'tracerisk_mission_failure_probability{controller="cell.py"} 4e-07\n' in metrics
    assert metrics.endswith("# EOF\n")
    # On the default branch there is nothing to compare with, and no note to write.
    notes = list(server.notes)
    for name in ("tracerisk.md", "tracerisk-quality.json", "tracerisk-metrics.txt"):
        (repository.folder / name).unlink()
    job("")
    assert server.notes == notes
    assert not (repository.folder / "tracerisk.md").exists()
    assert repository.read("tracerisk-metrics.txt").decode() == metrics
    assert json.loads(repository.read("tracerisk-quality.json"))
