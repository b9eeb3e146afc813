"""The tutorial notebook runs from its first cell to its last, and shows what its words say.

It is committed without outputs: they would differ in the last digits from machine to machine and
bury every change of its words. What they must show stands here.
"""

import re
from pathlib import Path

import pytest

FILE = Path(__file__).parents[1] / "docs" / "notebooks" / "tutorial.ipynb"


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """The outputs of each code cell, by its source."""
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed")
    notebook = nbformat.read(FILE, as_version=4)
    folder = tmp_path_factory.mktemp("notebook")
    client = nbclient.NotebookClient(
        notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    )
    client.execute()
    return {cell.source: cell.outputs for cell in notebook.cells if cell.cell_type == "code"}


def outputs(ran, ending):
    (found,) = [each for source, each in ran.items() if source.endswith(ending)]
    return found


def printed(ran, ending):
    return "".join(each.text for each in outputs(ran, ending) if each.output_type == "stream")


def value(ran, ending, kind="text/plain"):
    (found,) = [each for each in outputs(ran, ending) if each.output_type == "execute_result"]
    return found.data[kind]


def test_it_is_committed_without_outputs():
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")
    notebook = nbformat.read(FILE, as_version=4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert len(code) > 10
    assert all(not cell.outputs and cell.execution_count is None for cell in code)
    assert "/" + "tmp" not in FILE.read_text(encoding="utf-8")


def test_its_links_lead_to_pages():
    links = re.findall(r"\]\((\.\./[^)#]+)", FILE.read_text(encoding="utf-8"))
    assert len(links) >= 3
    assert all((FILE.parent / link).is_file() for link in links)


def test_trace_model_tree_and_assessment_show_themselves(ran):
    assert "<td>reach</td>" in value(ran, "\ntrace", "text/html")
    assert value(ran, "\ntrace").startswith("Trace of fetch.py: on panda in")
    assert "<svg" in value(ran, "\nmodel", "text/html")
    assert value(ran, "\nmodel").startswith("fetch.py: 3 functions")
    assert "<svg" in value(ran, "model.states[0].tree", "text/html")
    assert "Mission failure probability" in value(ran, "\nassessment", "text/html")
    assert "<svg" in value(ran, "\ncell", "text/html")


def test_the_blocks_are_those_of_the_functions(ran):
    text = printed(ran, 'split("def retreat")[0])')
    assert text.count("# | RiskAnnotation") == 2
    assert text.index("name = reach") < text.index("name = electric_motor")


def test_the_figures_are_what_the_words_say(ran):
    # Half the motors' figure, and all but the gripper's part is theirs.
    assert 0.5 < float(value(ran, "assessment.mission.failure_probability")) < 1.0
    swept = [float(each) for each in re.findall(r"mission (\S+)", printed(ran, ':.3e}")'))]
    assert len(swept) == 5
    assert swept == sorted(swept)
    low, middle, high = (
        float(each) for each in re.findall(r"below (\S+)", printed(ran, 'of the spread")'))
    )
    assert 0.0 < low < middle < high < 1e-4
    ratio = re.search(r"is (\S+) times", printed(ran, "change.summary)"))
    assert ratio is not None
    assert float(ratio[1]) > 1.2
    assert "look" in printed(ran, "change.summary)")
    # The hand, the pair, and two of three cameras: the sum of the sets, to first order.
    probability, counts = value(ran, "count_by_order()").strip("()").split(", ", 1)
    assert float(probability) == pytest.approx(1e-7 + 1e-8 + 3 * 4e-8, rel=1e-3)
    assert counts == "{1: 1, 2: 4}"
    assert float(value(ran, "solve(model).mission.failure_probability")) == pytest.approx(
        10 * float(probability), rel=1e-3
    )
