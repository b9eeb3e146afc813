"""`tracerisk history`: the risk over commits, from the blocks that git holds."""

import shutil
import subprocess
from xml.etree import ElementTree as ET

import pytest

from tests.conftest import RepositoryExample

LOCK = '{"controllers": {}, "schema": "tracerisk.lock", "version": 2}\n'
FIGURES = ("1e-07", "1e-07", "4e-07", "2e-07", "8e-07")


@pytest.fixture(scope="module")
def grown_once(tmp_path_factory, annotated_source):
    repository = RepositoryExample.empty(tmp_path_factory.mktemp("grown"))
    for number, figure in enumerate(FIGURES):
        source = annotated_source(pick=("done 1", f"gripper = {figure}"))
        repository.write("cell.py", f"# {number}\n{source}")
        repository.commit()
    return repository


@pytest.fixture
def grown(repository, grown_once):
    """A controller over five commits, of which the second changes no risk."""
    shutil.copytree(grown_once.folder, repository.folder, dirs_exist_ok=True)
    return repository


def commits(repository):
    return repository.git("log", "--format=%H", "--reverse").split()


def rows(outcome, name="cell.py"):
    assert outcome.code in (0, 1), outcome.err
    return outcome.json["controllers"][name]


def test_each_commit_that_changed_the_risk_is_a_row(grown):
    found = rows(grown.run("history", "cell.py", "--json"))
    hashes = commits(grown)[-5:]
    assert [each["commit"] for each in found["commits"]] == [
        hashes[0],
        hashes[2],
        hashes[3],
        hashes[4],
    ]
    assert [each["failure_probability"] for each in found["commits"]] == pytest.approx(
        [1e-7, 4e-7, 2e-7, 8e-7]
    )
    assert "through gripper" in found["commits"][1]["change"]


def test_the_commit_that_raised_it_most_is_reported(grown):
    found = rows(grown.run("history", "cell.py", "--json"))
    hashes = commits(grown)[-5:]
    assert found["largest_rise"]["commit"] in (hashes[2], hashes[4])
    assert found["largest_rise"]["ratio"] == pytest.approx(4.0)
    reported = grown.run("history", "cell.py")
    assert "largest rise: x4 by" in reported.out


def test_small_rises_add_up_to_one_that_is_shown(repository, annotated_source):
    for number in range(12):
        source = annotated_source(pick=("done 1", f"gripper = {1 + number / 250:.4f}e-06"))
        repository.write("cell.py", source)
        repository.commit()
    found = rows(repository.run("history", "cell.py", "--json"))["commits"]
    figures = [each["failure_probability"] for each in found]
    assert len(figures) < 12, "each alone is noise"
    assert figures == sorted(figures)
    assert figures[-1] == pytest.approx(1.044e-6, rel=0.01)
    assert repository.run("history", "cell.py", "--above", "1.03e-6").code == 1


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(("limit", "since"), [("5e-7", 4), ("1.5e-7", 2), ("1e-6", None)])
def test_since_which_commit_it_is_above_a_limit(grown, limit, since):
    outcome = grown.run("history", "cell.py", "--above", limit, "--json")
    assert outcome.code == (0 if since is None else 1)
    hashes = commits(grown)[-5:]
    assert rows(outcome)["above_since"] == (None if since is None else hashes[since])


def test_what_is_not_committed_comes_last(grown, annotated_source):
    grown.write("cell.py", annotated_source(pick=("done 1", "gripper = 3e-06")))
    found = rows(grown.run("history", "cell.py", "--json"))
    assert found["commits"][-1]["commit"] == ""
    assert found["commits"][-1]["failure_probability"] == pytest.approx(3e-6)
    assert "working tree" in grown.run("history", "cell.py").out


def test_a_file_is_followed_to_its_new_name(grown):
    grown.git("mv", "cell.py", "work.py")
    grown.commit()
    found = rows(grown.run("history", "work.py", "--json"), "work.py")
    assert [each["path"] for each in found["commits"]] == ["cell.py"] * 4
    assert found["commits"][-1]["failure_probability"] == pytest.approx(8e-7)


def test_the_last_commits_alone(grown):
    found = rows(grown.run("history", "cell.py", "--most", "2", "--json"))
    assert [each["failure_probability"] for each in found["commits"]] == pytest.approx([2e-7, 8e-7])


def test_a_commit_whose_blocks_cannot_be_read_is_a_row_and_no_end(grown, annotated_source):
    source = grown.read("cell.py").decode()
    grown.write("cell.py", source.replace("quantity = 1", "quantity = many"))
    grown.commit()
    grown.write("cell.py", annotated_source(pick=("done 1", "gripper = 9e-07")))
    grown.commit()
    found = rows(grown.run("history", "cell.py", "--json"))
    assert "quantity" in found["commits"][-2]["error"]
    assert found["commits"][-2]["failure_probability"] is None
    assert found["commits"][-1]["failure_probability"] == pytest.approx(9e-7)
    assert "unreadable" in grown.run("history", "cell.py").out


def test_the_chart_has_a_dot_for_each_and_the_badge_the_last_figure(grown):
    outcome = grown.run("history", "cell.py", "--svg", "h.svg", "--badge", "b.svg")
    assert outcome.code == 0, outcome.err
    chart = ET.fromstring(grown.read("h.svg"))
    assert len(chart.findall(".//{*}circle")) == 4
    badge = ET.fromstring(grown.read("b.svg"))
    texts = [each.text for each in badge.findall(".//{*}text")]
    assert texts == ["mission failure", "8.00e-07, unknown"]
    again = grown.run("history", "cell.py", "--svg", "h2.svg")
    assert again.code == 0
    assert grown.read("h2.svg") == grown.read("h.svg")


def test_all_controllers_of_the_lock_where_none_is_named(grown):
    outcome = grown.run("history")
    assert outcome.code == 2
    assert "knows a controller; name a FILE" in outcome.err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("nothing.py",), "does not exist"),
        (("new.py",), "git has no commit of it"),
        (("cell.py", "new.py", "--badge", "b.svg"), "--badge is that of one controller"),
    ],
)
def test_what_cannot_be_reported_is_said(grown, words, message):
    grown.write("new.py", "x = 1\n")
    outcome = grown.run("history", *words)
    assert outcome.code == 2
    assert message in outcome.err


def test_outside_a_repository_it_is_said(example):
    example.write("cell.py", "x = 1\n")
    inside = subprocess.run(
        ["git", "rev-parse"], cwd=example.folder, capture_output=True, check=False
    )
    if inside.returncode == 0:
        pytest.skip("the folder for tests lies in a repository")
    outcome = example.run("history", "cell.py")
    assert outcome.code == 2
    assert "repository" in outcome.err


def test_subjects_with_odd_signs_and_merges_are_read(grown, annotated_source):
    grown.git("checkout", "--quiet", "-b", "side", "HEAD~1")
    grown.write("cell.py", annotated_source(pick=("done 1", "gripper = 6e-07")))
    grown.git("add", "--all")
    grown.git("commit", "--quiet", "--message", "ü \" <b> 'x' & \t y")
    grown.git("checkout", "--quiet", "-")
    grown.git("merge", "--quiet", "--strategy", "ours", "side")
    outcome = grown.run("history", "cell.py", "--json", "--svg", "h.svg")
    found = rows(outcome)
    assert any("<b>" in each["subject"] for each in found["commits"])
    assert found["commits"][-1]["failure_probability"] == pytest.approx(8e-7)


def test_many_controllers_are_followed_at_once_and_each_as_if_alone(
    grown, annotated_source, monkeypatch
):
    from tracerisk.pipeline.review import controllers
    from tracerisk.pipeline.review.history import histories, history

    for number, figure in enumerate(FIGURES):
        grown.write("Zelle 2/größer.py", annotated_source(pick=("done 1", f"arm = {figure}")))
        grown.write("tracerisk.lock", LOCK + number * "\n")
        grown.commit()
    paths = [grown.folder / "cell.py", grown.folder / "Zelle 2/größer.py"]
    alone = tuple(history(each) for each in paths)
    read = []
    reader = controllers.loads
    monkeypatch.setattr(
        controllers, "loads", lambda data, file: read.append(data) or reader(data, file)
    )
    assert histories(paths) == alone
    # Once for each commit that has a lock, and for the working tree; not for each controller.
    assert len(read) == len(FIGURES) + 1


def test_a_repository_without_a_commit_is_named(example):
    subprocess.run(["git", "init", "--quiet"], cwd=example.folder, check=True)
    example.write("cell.py", "")
    done = example.run("history", "cell.py")
    assert done.code == 2
    assert "has no commit yet; commit first" in done.err


def test_a_shallow_clone_is_said_to_lack_older_commits(grown, example_in, tmp_path):
    source = f"file://{grown.folder}"
    clone = ["git", "clone", "--quiet", "--depth", "1", source, str(tmp_path / "clone")]
    subprocess.run(clone, check=True)
    shallow = example_in(tmp_path / "clone")
    done = shallow.run("history", "cell.py")
    assert done.code == 0, done.err
    assert "this clone is shallow, and older commits are not in it" in done.err
    assert "shallow" not in grown.run("history", "cell.py").err


def test_one_figure_is_not_said_never_to_have_risen_and_controllers_stand_apart(
    repository, annotated_source
):
    for name in ("one.py", "two.py"):
        repository.write(name, annotated_source(pick=("done 1", "gripper = 1e-07")))
    repository.commit()
    shown = repository.run("history", "one.py", "two.py").out
    assert shown.count("nothing to compare with yet") == 2
    assert "never rose" not in shown
    assert "\n\ntwo.py" in shown


def test_the_last_label_of_a_chart_stays_within_it(grown, annotated_source):
    grown.write("cell.py", annotated_source(pick=("done 1", "gripper = 9e-07")))
    grown.run("history", "cell.py", "--svg", "h.svg")
    chart = ET.fromstring(grown.read("h.svg"))
    (label,) = (each for each in chart.findall(".//{*}text") if each.text == "working tree")
    half = len(label.text) * 7.3 / 2
    assert float(label.get("x")) + half <= float(chart.get("width"))


def test_a_commit_of_a_side_branch_is_compared_with_its_parent(repository, annotated_source):
    def commit(pick, place):
        steps = {"pick": ("place 1", f"gripper = {pick}"), "place": ("done 1", f"motor = {place}")}
        repository.write("cell.py", annotated_source(**steps))
        repository.commit()

    commit("1e-07", "1e-07")
    repository.git("branch", "-M", "main")
    repository.git("switch", "-q", "-c", "side")
    commit("1e-07", "3e-07")
    repository.git("switch", "-q", "main")
    commit("5e-07", "1e-07")
    repository.git("switch", "-q", "side")
    commit("1e-07", "4e-07")
    repository.git("switch", "-q", "main")
    repository.git("merge", "-q", "-m", "merged", "side")
    commit("5e-07", "8e-07")
    found = rows(repository.run("history", "cell.py", "--json"))
    told = [
        (point["failure_probability"], point["change"].partition("rises from ")[2][:22])
        for point in found["commits"]
    ]
    assert sorted(told[1:]) == [
        (pytest.approx(4e-7), "2.000e-07 to 4.000e-07"),
        (pytest.approx(5e-7), "4.000e-07 to 5.000e-07"),
        (pytest.approx(6e-7), "2.000e-07 to 6.000e-07"),
        (pytest.approx(1.3e-6), "9.000e-07 to 1.300e-06"),
    ]
    assert found["largest_rise"]["ratio"] == pytest.approx(3.0)
    table = repository.run("history", "cell.py").out
    assert {"x2", "x1.25", "x3", "x1.44"} <= set(table.split())


def test_a_commit_is_one_line_of_eighty_columns(repository, annotated_source, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    for figure, subject in (("1e-07", "First"), ("4e-07", "A long subject " * 9)):
        repository.write("cell.py", annotated_source(pick=("done 1", f"gripper = {figure}")))
        repository.git("add", "--all")
        repository.git("commit", "--quiet", "--message", subject)
    lines = repository.run("history", "cell.py").out.splitlines()
    assert max(map(len, lines[:5])) <= 80
    first, second = lines[3:5]
    assert first.split()[-1] == "First"
    assert second.endswith("...")
    assert "x4" in second.split()
    assert "verdict unknown" in second
