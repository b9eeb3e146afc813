"""What a release is made of: one version, a workflow and an image that take nothing unpinned."""

import importlib.util
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from tracerisk.cli.set_up.docs import PACKED, page_names, page_text
from tracerisk.cli.verbs import VERBS
from tracerisk.common.settings.settings_file import loads_toml
from tracerisk.common.version import UNKNOWN

ROOT = Path(__file__).parents[1]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
PROJECT = loads_toml((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_a_tree_without_git_has_the_version_of_a_tree_without_metadata():
    assert PROJECT["tool"]["hatch"]["version"]["raw-options"]["fallback_version"] == UNKNOWN


def test_what_extras_share_has_one_range():
    ranges: dict[str, set[str]] = {}
    extras = PROJECT["project"]["optional-dependencies"].values()
    for each in [
        *PROJECT["project"]["dependencies"],
        *(line for extra in extras for line in extra),
    ]:
        name = re.split(r"[<>=;\[]", each)[0]
        if name != "tracerisk":
            ranges.setdefault(name, set()).add(each)
    assert {name: found for name, found in ranges.items() if len(found) > 1} == {}


@pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.name)
def test_workflows_take_actions_by_their_digests(workflow):
    jobs = YAML(typ="safe").load(workflow.read_text(encoding="utf-8"))["jobs"]
    used = [step["uses"] for job in jobs.values() for step in job["steps"] if "uses" in step]
    assert used
    for each in used:
        assert re.fullmatch(r"[\w/-]+@[0-9a-f]{40}", each), each


@pytest.fixture
def hatch_build():
    pytest.importorskip("hatchling", reason="hatchling is not installed")
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def made(hatch_build, monkeypatch):
    """Makes the metadata of a version, built where a repository is said to be."""

    def make(version: str, repository: str = "") -> dict:
        monkeypatch.setenv(hatch_build.REPOSITORY, repository)
        metadata = {"version": version}
        hatch_build.CustomMetadataHook(str(ROOT), {}).update(metadata)
        return metadata

    return make


def test_a_wheel_names_the_commit_of_sources_that_are_just_those_of_one(hatch_build, tmp_path):
    def git(*words: str) -> str:
        who = ("-c", "user.name=me", "-c", "user.email=me@example.org")
        return subprocess.run(
            ["git", *who, *words], cwd=tmp_path, check=True, capture_output=True, text=True
        ).stdout.strip()

    assert hatch_build.built_commit(tmp_path) == ""
    git("init", "-q")
    assert hatch_build.built_commit(tmp_path) == ""
    (tmp_path / "arm.py").write_text("one\n")
    git("add", "arm.py")
    git("commit", "-qm", "One")
    (tmp_path / "build.log").write_text("left by somebody\n")
    assert hatch_build.built_commit(tmp_path) == git("rev-parse", "HEAD")
    (tmp_path / "arm.py").write_text("two\n")
    assert hatch_build.built_commit(tmp_path) == ""


def test_links_of_the_description_lead_to_the_tag(made):
    metadata = made("0.2.0", "https://git.example.org/tracerisk/")
    text = metadata["readme"]["text"]
    links = re.findall(r"\]\(([^)\s]+)\)", text)
    assert all(link.startswith("https://") for link in links)
    here = "https://git.example.org/tracerisk/blob/v0.2.0/docs/blocks.md"
    assert f"]({here})" in text
    assert f"]({here.replace('blocks.md', 'report.md#films')})" in text
    pictures = re.findall(r"!\[[^\]]*\]\(([^)\s]+)\)", text)
    raw = "https://git.example.org/tracerisk/raw/v0.2.0/docs/pictures/"
    assert pictures
    assert all(each.startswith(raw) for each in pictures)
    assert all((ROOT / "docs/pictures" / each.removeprefix(raw)).is_file() for each in pictures)
    assert set(metadata["urls"]) == {"Documentation", "Source", "Changelog", "Issues"}


def test_without_a_repository_there_are_no_links_to_one(made):
    metadata = made("0.2.0.dev3")
    assert "urls" not in metadata
    assert metadata["readme"]["text"] == (ROOT / "README.md").read_text(encoding="utf-8")


def test_an_installed_package_has_the_pages_packed(hatch_build, tmp_path):
    places = hatch_build.packed_data(ROOT, tmp_path)
    (made,) = [made for made, place in places.items() if place.endswith(PACKED)]
    before = Path(made).read_bytes()
    hatch_build.packed_data(ROOT, tmp_path)
    assert Path(made).read_bytes() == before
    with zipfile.ZipFile(made) as packed:
        assert [name.removesuffix(".md") for name in sorted(packed.namelist())] == page_names()
        assert packed.read("verdict.md").decode() == page_text("verdict")
    assert len(before) < 350_000


@pytest.mark.parametrize(
    ("variables", "system", "said"),
    [
        ({"PATH": "/nowhere"}, "linux", "no C compiler: "),
        (
            {"CC": "/nowhere/cc"},
            "darwin",
            "/nowhere/cc cannot be run (No such file or directory): ",
        ),
        ({"CC": "false -x"}, "linux", "false failed (it ended with 1): "),
        ({"TRACERISK_PURE": "1"}, "linux", None),
        ({}, "win32", None),
    ],
)
def test_without_a_compiler_one_line_says_that_the_loops_are_python(
    hatch_build, monkeypatch, tmp_path, capfd, variables, system, said
):
    monkeypatch.delenv("CC", raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(hatch_build.sys, "platform", system)
    assert not hatch_build.compile_loops(ROOT, tmp_path / "loops.so")
    slow = "trees are solved by Python alone, and large ones take very long\n"
    assert capfd.readouterr().err == ("" if said is None else f"{said}{slow}")
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def man_page(hatch_build, monkeypatch):
    pytest.importorskip("argparse_manpage", reason="argparse-manpage is not installed")
    monkeypatch.setenv("COLUMNS", "80")
    return hatch_build.man_page(ROOT, "0.1.0")


def test_the_man_page_has_each_verb_with_its_options_and_the_exit_codes(man_page):
    assert man_page.startswith(".TH TRACERISK ")
    found = re.findall(r"^\.SS \\fBtracerisk ([a-z\\-]+)\\fR$", man_page, re.MULTILINE)
    assert [verb.replace("\\", "") for verb in found][: len(VERBS)] == list(VERBS)
    for words in (r"\fB\-\-max\-increase\fR", ".SH EXIT STATUS", "conflicting manual edit"):
        assert words in man_page


@pytest.mark.skipif(shutil.which("groff") is None, reason="needs groff")
def test_the_man_page_is_set_without_a_complaint(man_page):
    command = ["groff", "-ww", "-man", "-Tutf8"]
    done = subprocess.run(command, input=man_page, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert "tracerisk 0.1.0" in done.stdout
