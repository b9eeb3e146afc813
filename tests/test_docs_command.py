"""docs/command.md lists every verb, every exit code, options that exist and JSON as it is printed."""

import re
import shlex
import subprocess
from pathlib import Path

import pytest

from tracerisk.cli import main
from tracerisk.cli.parser import whole_parser
from tracerisk.cli.verbs import VERBS
from tracerisk.errors import ExitCode

TEXT = (Path(__file__).parents[1] / "docs" / "command.md").read_text(encoding="utf-8")
ROWS = {
    cells[0]: cells[1:]
    for cells in re.findall(r"^\| `([\w-]+)` \| (.*) \| (.*) \| (.*) ?\|$", TEXT, re.MULTILINE)
}


def test_every_verb_is_listed():
    assert set(ROWS) == set(VERBS)


@pytest.mark.parametrize("verb", ROWS)
def test_options_that_a_row_names_are_options_of_the_verb(verb):
    verbs = next(each for each in whole_parser()._actions if each.dest == "verb").choices
    known = {word for action in verbs[verb]._actions for word in action.option_strings}
    assert set(re.findall(r"`(--[\w-]+)`", " ".join(ROWS[verb]))) <= known


def test_every_exit_code_is_listed():
    assert [int(code) for code in re.findall(r"^\| (\d+) \|", TEXT, re.MULTILINE)] == list(ExitCode)


def test_the_json_is_printed_so(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    ((command, shown),) = re.findall(
        r"^```console\n\$ ([^\n]*)\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL
    )
    assert main(shlex.split(command)[1:]) == ExitCode.BAD_INPUT
    out, err = capfd.readouterr()
    assert out + err == shown


def test_the_completion_is_a_script_that_the_shell_takes(example):
    (commands,) = re.findall(r"^```sh\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
    first, second = commands.splitlines()
    command, _, path = first.partition(" > ")
    outcome = example.run(*shlex.split(command)[1:])
    assert outcome.code == 0
    example.write(path, outcome.out)
    done = subprocess.run(
        ["bash", "-c", second], cwd=example.folder, capture_output=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, b"")
