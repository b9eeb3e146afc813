"""Where options may be given on the command line."""

import pytest

from tracerisk.cli import _plain
from tracerisk.cli.parser import _parser
from tracerisk.cli.verbs import VERBS


def parsed(verb: str, *words: str) -> dict[str, object]:
    return vars(_parser(verb, as_json=False).parse_args([verb, *words]))


@pytest.mark.parametrize("verb", ["run", "trace"])
def test_options_go_before_or_after_the_controller_and_its_arguments_come_last(verb):
    wanted = parsed(verb, "--robot", "ur5e", "--quiet", "c.py", "--", "left", "--speed", "2")
    assert wanted["argv"] == ["left", "--speed", "2"]
    after = parsed(verb, "c.py", "--robot", "ur5e", "--quiet", "--", "left", "--speed", "2")
    around = parsed(verb, "--robot", "ur5e", "c.py", "--quiet", "--", "left", "--speed", "2")
    assert (after, around) == (wanted, wanted)
    assert parsed(verb, "c.py", "left", "--quiet", "--", "--", "2")["argv"] == ["left", "--", "2"]
    assert parsed(verb, "--", "-c.py", "2")["controller"] == "-c.py"


LISTS = sorted(
    verb
    for verb in VERBS
    if (parser := _parser(verb, as_json=False).chosen) is not None and parser._list
)


@pytest.mark.parametrize("verb", LISTS)
def test_options_of_a_list_of_files_go_anywhere_before_the_dashes(verb):
    options = ["--json", *(["-o", "model.xml"] if verb in ("convert", "headers") else [])]
    wanted = parsed(verb, *options, "a", "b", "--", "-c")
    assert parsed(verb, "a", *options, "b", "--", "-c") == wanted
    assert parsed(verb, "a", "b", *options, "--", "-c") == wanted
    assert ["a", "b", "-c"] in wanted.values()


def test_an_option_that_is_unknown_is_one_wherever_it_is_given(capsys):
    for words in (("--sped", "c.py", "--", "x"), ("c.py", "--sped", "--", "x")):
        with pytest.raises(SystemExit):
            parsed("run", *words)
        assert "unknown option --sped" in capsys.readouterr().err


@pytest.mark.parametrize("verb", ["check", "solve"])
@pytest.mark.parametrize(
    "words",
    [[], ["a.py"], ["-q"], ["a.py", "-q", "b c.py"], ["--quiet", "a.py"], ["", "a.py", "-q", "-q"]],
)
def test_files_alone_need_no_parser_and_are_read_the_same(verb, words):
    options = _plain([verb, *words])
    if verb == "solve" and set(words) <= {"-q"}:
        assert options is None  # the parser says that it needs a file
    else:
        assert options is not None
        assert vars(options) == parsed(verb, *words)


@pytest.mark.parametrize(
    "line",
    [
        *(
            "",
            "-q check",
            "check -h",
            "check --json",
            "check -qq",
            "check a.py --",
            "check -- a.py",
        ),
        *("check --min-coverage 1 a.py", "check --bas x", "check --watch", "check -x", "checks"),
        *("run a.py", "check -", "solve", "solve -q", "solve a.py --json", "solve -- a.py"),
    ],
)
def test_every_other_command_line_is_for_the_parser(line):
    assert _plain(line.split()) is None
