"""What the README shows is what happens; CI runs its two set-up commands."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)


def test_the_library_example_prints_the_missions_failure_probability(capsys):
    (code,) = [block for block in blocks("python") if "import" in block]
    exec(compile(code, "README.md", "exec"), {})
    assert capsys.readouterr().out == "7.344e-08\n"


def test_the_block_shown_is_part_of_what_the_run_writes(example, pick_and_place):
    example.write("pick_and_place.py", pick_and_place)
    assert example.run("run", "pick_and_place.py", "--quiet").code == 0
    written = example.read("pick_and_place.py").decode()
    (shown,) = [block for block in blocks("python") if "import" not in block]
    figure = re.compile(r"probability = (\S+)")
    # The digest is that of the figures, whose last digits depend on the processor.
    digest = re.compile(r"(?<=RiskAnnotation) \S+")
    assert digest.search(shown)
    shown, written = digest.sub("", shown), digest.sub("", written)
    function, component = figure.sub("probability", shown).split("    # | @Component {\n")
    text = figure.sub("probability", written)
    assert function in text
    assert component.removesuffix('    """Take the tube out of the rack."""\n') in text
    # The last digits may differ on a machine whose processor rounds otherwise.
    entry = written[written.index("name = gripper") :]
    assert float(figure.search(entry)[1]) == pytest.approx(float(figure.search(shown)[1]), rel=0.01)


@pytest.mark.parametrize("verb", re.findall(r"^\| `tracerisk ([\w-]+)", README, re.MULTILINE))
def test_every_verb_of_the_table_has_a_help(verb, capsys):
    from tracerisk.cli import main
    from tracerisk.cli.verbs import VERBS

    assert verb in VERBS
    with pytest.raises(SystemExit) as ended:
        main([verb, "--help"])
    assert ended.value.code == 0
    assert "usage: tracerisk" in capsys.readouterr().out


def test_every_verb_stands_in_a_table_and_the_first_ones_here():
    from tracerisk.cli.verbs import VERBS

    row = re.compile(r"^\| `tracerisk ([\w-]+)", re.MULTILINE)
    page = (ROOT / "docs" / "command.md").read_text(encoding="utf-8")
    assert set(row.findall(page)) == set(VERBS)
    assert row.findall(README) == ["init", "run", "check", "diff", "report"]


def test_the_files_that_show_the_elements_are_there():
    rows = re.findall(r"\| `(tracerisk/\w+)`[^|]*\| `([\w/]+\.py)` \|$", README, re.MULTILINE)
    assert len(rows) == 4
    assert [name for name in rows if not ROOT.joinpath(*name).is_file()] == []


def test_links_lead_to_files():
    for target in re.findall(r"\]\(((?!http)[^)#]+)", README):
        assert (ROOT / target).exists(), target


def test_ci_finds_both_commands_in_the_readme():
    commands = blocks("sh")
    assert [sum(word in each for each in commands) for word in ("tracerisk run ", "pytest")] == [
        1,
        1,
    ]
    assert all(each.count("\n") == 1 for each in commands)
