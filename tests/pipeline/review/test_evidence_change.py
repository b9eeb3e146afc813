"""What a diff says where one version's figures take evidence, and the other's do not."""

from dataclasses import replace

import pytest

from tests.pipeline.review.test_outcome import COMPLETE
from tests.pipeline.review.test_review import lock_of, only, write
from tracerisk.adder.lock.digest import with_digest
from tracerisk.adder.sources.insert import insert_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.common.evidence.cells import Cell, Evidence
from tracerisk.common.evidence.file import dump_evidence
from tracerisk.instrument.source.code_digest import code_digest
from tracerisk.pipeline.review.review import review

TRIED = "dead 1: stopped safely 1/2, unaware 1/2"
MORE = "dead 1: stopped safely 3/4, unaware 1/4"


@pytest.fixture
def both(repository, annotated_source):
    """Two runs of a controller: of each its figure, what follows failures, evidence and code."""

    def make(*versions: tuple[str, str, str, str]):
        for number, (figure, follows, evidence, code) in enumerate(versions):
            text = annotated_source(place=("done 1", f"gripper = {figure}"))
            text += f"\n\nCODE = {code!r}\n"
            if follows:
                section = (
                    "    # | @Failure {\n    # |   component = gripper\n"
                    f"    # |   mode = {follows}\n    # | }}\n"
                )
                text = text.replace("    arm.go", f"{section}    arm.go")
            blocks = {
                placed.function: with_digest(placed.block)
                for placed in read_blocks(text.encode(), "pick.py")
            }
            source = {"pick.py": insert_blocks(text.encode(), blocks, "pick.py").decode()}
            digest = code_digest(source["pick.py"].encode(), "pick.py")
            inputs = {"sources": {"pick.py": digest}, "evidence": evidence}
            entry = replace(lock_of(source, "pick.py", **inputs), trace={"verdict": COMPLETE})
            write(repository, source, ("pick.py", entry))
            if number == 0:
                repository.commit()
        return repository

    return make


def test_lost_evidence_is_neither_code_nor_an_edit(both):
    repository = both(("2e-07", TRIED, "d", "a"), ("3e-07", "", "", "b"))
    diff = only(review([], repository.folder))
    assert not diff.is_comparable
    causes = {change.fields[0].key: change.causes for change in diff.changes}
    assert causes == {"failures": ("evidence",), "probability": ("code", "evidence")}
    said = " ".join(repository.run("diff").out.split())
    assert (
        "pick.py: evidence is no longer taken: there is none; mission failure is 3.000e-07 now "
        "and was 2.000e-07, not comparable with and without evidence; what is undetected is no "
        "longer known, it was 1.000e-07; `tracerisk evidence pick.py` tries the failures again."
        in said
    )
    assert "tracerisk.evidence is no longer taken" in said
    for wrong in ("edited by hand", "[code]", "rises", "x1.5"):
        assert wrong not in said
    assert said.count("no longer known") == 1


def test_lost_evidence_is_told_in_every_output(both):
    repository = both(("2e-07", TRIED, "d", "a"), ("2e-07", "", "", "b"))
    for form in ("text", "markdown"):
        outcome = repository.run("diff", "--format", form, "--silent-below", "0.5")
        assert "evidence is no longer taken" in " ".join(outcome.out.split())
    (data,) = repository.run("diff", "--json").json["controllers"]
    assert data["evidence_change"] == "evidence is no longer taken: there is none"
    assert (data["is_comparable"], data["ratio"], data["causes"]) == (False, None, [])
    assert repository.run("report", "pick.py", "--against", "HEAD", "-o", "r.html").code == 0
    page = repository.read("r.html").decode()
    assert "evidence is no longer taken" in page
    assert 'id="difference-1-changes-table"' not in page


def test_first_evidence_lets_no_figure_look_safer(both):
    repository = both(("3e-07", "", "", "a"), ("2e-07", TRIED, "d", "a"))
    said = " ".join(repository.run("diff").out.split())
    assert (
        "evidence is taken now and was not before; mission failure is 2.000e-07 now and was "
        "3.000e-07, not comparable with and without evidence; undetected is 1.000e-07." in said
    )
    assert "falls" not in said


def test_the_limit_on_the_increase_holds_without_evidence(both):
    repository = both(("2e-07", TRIED, "d", "a"), ("3e-07", "", "", "b"))
    outcome = repository.run("diff", "--max-increase", "0.1")
    assert outcome.code == 1
    assert "is more by 50 %, over --max-increase 0.1, though the figures are not" in outcome.err
    assert "evidence is no longer taken" in outcome.err


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("code", "cause"), [("a", "evidence"), ("b", "code")], ids=["alone", "with the code"]
)
def test_other_evidence_is_a_cause_where_nothing_else_is(both, code, cause):
    repository = both(("2e-07", TRIED, "d", "a"), ("3e-07", MORE, "e", code))
    diff = only(review([], repository.folder))
    assert diff.is_comparable
    assert {change.causes for change in diff.changes} == {(cause,)}
    said = " ".join(repository.run("diff").out.split())
    assert "mission failure rises from 2.000e-07 to 3.000e-07 (x1.5), mostly through" in said
    assert "; undetected of it " in said
    assert "tracerisk.evidence has changed" in said


def test_what_nobody_notices_stands_in_the_table_of_every_output(both):
    repository = both(("2e-07", TRIED, "d", "a"), ("3e-07", MORE, "e", "b"))
    rows = [" ".join(line.split()) for line in repository.run("diff").out.splitlines()]
    assert "undetected 1.000e-07 7.500e-08 x0.75" in rows
    assert "stopped safely 1.000e-07 2.250e-07 x2.25" in rows
    comment = repository.run("diff", "--format", "markdown").out
    assert "| undetected | stopped safely |" in comment
    assert "| 1.000e-07 → 7.500e-08 (x0.75) | 1.000e-07 → 2.250e-07 (x2.25) |" in comment
    assert repository.run("report", "pick.py", "--against", "HEAD", "-o", "r.html").code == 0
    page = repository.read("r.html").decode()
    section = page[page.index('id="difference-1-mission-table"') :]
    section = section[: section.index("</table>")]
    for shown in ("undetected", "7.500e-08", "x0.75", "stopped safely", "2.250e-07"):
        assert shown in section


def test_what_is_not_known_of_one_version_is_said_so_in_the_table(both):
    repository = both(("2e-07", TRIED, "d", "a"), ("3e-07", "", "", "b"))
    rows = [" ".join(line.split()) for line in repository.run("diff").out.splitlines()]
    assert "undetected 1.000e-07 -" in rows
    assert "| 1.000e-07 → not known |" in repository.run("diff", "--format", "markdown").out


def test_a_check_is_credited_beside_the_missions_that_it_ends(both):
    def tried(*outcomes):
        cells = (
            Cell(
                *("gripper", "hand", "dead", float(at), "moving", "place", True, float(at)),
                (float(at), 0.0, 0.0),
                fails=fate != "carried_out",
                fate=fate,
                noticed_by=noticed,
            )
            for at, (fate, noticed) in enumerate(outcomes)
        )
        kept = Evidence("f", "panda", 0, len(outcomes), ("done",), tuple(cells))
        return dump_evidence({"pick.py": kept})

    repository = both(("2e-07", TRIED, "d", "a"), ("3e-07", MORE, "e", "b"))
    later = {name: repository.read(name).decode() for name in ("pick.py", "tracerisk.lock")}
    repository.git("checkout", "-q", "--", ".")
    unchecked = [("unaware", None)] * 12 + [("carried_out", None)] * 8
    repository.write("tracerisk.evidence", tried(*unchecked))
    repository.commit()
    checked = [("stopped_safely", "code")] * 18 + [("carried_out", None)] * 2
    for name, text in {**later, "tracerisk.evidence": tried(*checked)}.items():
        repository.write(name, text)
    for form in ("text", "markdown"):
        said = " ".join(repository.run("diff", "--format", form).out.split())
        assert (
            "a failure of gripper (dead) now is undetected in 0 of 20 tries, before: 12 of 20; is "
            "noticed by the controller in 18 of 20 tries, before: 0 of 20; ends the mission in 18 "
            "of 20 tries, before: 12 of 20; is stopped safely in 18 of 20 tries, before: 0 of 20"
        ) in said
        assert "What failures on the twin do now that they did not before" in said


def test_no_row_stands_for_what_neither_version_knows(both):
    repository = both(("2e-07", "", "", "a"), ("3e-07", "", "", "b"))
    for form in ("text", "markdown"):
        assert "undetected" not in repository.run("diff", "--format", form).out
