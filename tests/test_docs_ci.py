"""What docs/howto-ci.md says of the CI files is what these files have."""

import re
from pathlib import Path

import pytest
from ruamel.yaml import YAML

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs" / "howto-ci.md").read_text(encoding="utf-8")
TEMPLATES = ROOT / "tracerisk" / "pipeline" / "start" / "templates"
IN_WORDS = {
    "no limit": "",
    "every controller of `tracerisk.lock`": "",
    "that of the job": "${{ github.token }}",
}

pytestmark = pytest.mark.skipif(not (ROOT / "action.yml").is_file(), reason="needs the repository")


def table(head: str) -> dict[str, str]:
    rows = TEXT.partition(f"| {head} | default | meaning |\n|---|---|---|\n")[2].partition("\n\n")[
        0
    ]
    cells = [row.split(" | ") for row in rows.splitlines()]
    return {
        name.strip("| `"): IN_WORDS.get(default, default.strip("`")) for name, default, _ in cells
    }


def test_the_inputs_of_the_action_stand_there_with_their_defaults():
    action = YAML(typ="safe").load(ROOT / "action.yml")
    assert table("input") == {name: given["default"] for name, given in action["inputs"].items()}


def test_the_variables_of_the_job_of_gitlab_stand_there_with_their_defaults():
    job = YAML(typ="safe").load(TEMPLATES / "gitlab.yaml")["tracerisk"]
    assert table("variable") == {**job["variables"], "TRACERISK_TOKEN": "no note"}


def test_the_workflow_is_the_one_that_init_writes():
    shipped = (TEMPLATES / "github.yaml").read_text(encoding="utf-8")
    assert f"```yaml\n{shipped.replace('ACTION', 'OWNER/tracerisk@v0.1.0')}```\n" in TEXT


def test_one_version_is_named_wherever_one_is():
    pages = [page.read_text("utf-8") for page in (ROOT / "docs").glob("*.md")]
    named = {
        version
        for page in pages
        for version in re.findall(r"(?:OWNER/tracerisk\S*@|rev: )(v[\d.]+)", page)
    }
    assert named == {"v0.1.0"}
