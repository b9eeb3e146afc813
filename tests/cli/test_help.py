"""What `--help` shows: readable in 80 columns, alike for every verb."""

import argparse
import re

import pytest

from tracerisk.cli import main
from tracerisk.cli.parser import whole_parser
from tracerisk.cli.verbs import GROUPS, VERBS

PROPER = {"Markdown", "PRISM"}


def verb_parsers(parser=None):
    """Every parser of a verb, those of actions of a verb too."""
    for action in (parser or whole_parser())._actions:
        if isinstance(action, argparse._SubParsersAction):
            for sub in action.choices.values():
                yield sub
                yield from verb_parsers(sub)


def help_of(capsys, monkeypatch, *words):
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit) as ended:
        main([*words, "--help"])
    assert ended.value.code == 0
    return capsys.readouterr().out


def test_every_verb_stands_in_one_group_and_once_in_the_help(capsys, monkeypatch):
    assert sorted(verb for group in GROUPS.values() for verb in group) == sorted(VERBS)
    text = help_of(capsys, monkeypatch)
    for verb, summary in VERBS.items():
        assert len(re.findall(rf"^  {verb} +{re.escape(summary)}$", text, re.MULTILINE)) == 1
    places = [text.index(f"{title}:\n") for title in (*GROUPS, "options", "exit codes")]
    assert places == sorted(places)


def test_the_bare_command_prints_its_help_as_a_usage_error(capsys, monkeypatch):
    text = help_of(capsys, monkeypatch)
    with pytest.raises(SystemExit) as ended:
        main([])
    assert ended.value.code == 2
    assert capsys.readouterr() == ("", text)


def test_no_verb_that_prints_refuses_verbose():
    for parser in verb_parsers():
        options = parser._option_string_actions
        assert ("-v" in options) == ("--quiet" in options), parser.prog


@pytest.mark.parametrize("verb", ["", *VERBS])
def test_help_fits_eighty_columns(verb, capsys, monkeypatch):
    text = help_of(capsys, monkeypatch, *([verb] if verb else []))
    assert max(map(len, text.splitlines())) <= 80
    # What must be given is in the first line, all else in the lists below it.
    assert text[: text.index("\n\n")].count("\n") < 3


def test_options_begin_small_and_end_without_a_full_stop():
    for parser in verb_parsers():
        assert re.fullmatch(r"[A-Z].*\.", parser.description, re.DOTALL), parser.prog
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction):
                continue
            text = action.help or ""
            assert text, parser.prog
            first = text.split()[0].strip(",")
            where = f"{parser.prog} {action.option_strings or action.dest}: {text}"
            assert first == first.lower() or first.isupper() or first in PROPER, where
            assert not text.endswith("."), where
        for group in parser._action_groups:
            assert group.title == group.title.lower()


def test_usage_names_what_must_be_given(capsys, monkeypatch):
    lines = help_of(capsys, monkeypatch, "convert").splitlines()
    assert lines[0] == "usage: tracerisk convert [options] -o FILE FILE [FILE ...]"
    lines = help_of(capsys, monkeypatch, "strip").splitlines()
    assert lines[0].startswith("usage: tracerisk strip [-h] [--check] [--diff]")
