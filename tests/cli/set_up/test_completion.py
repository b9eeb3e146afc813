import shutil
import subprocess

import pytest

from tracerisk.cli.set_up.completion import SHELLS
from tracerisk.cli.verbs import VERBS

COMPLETE = """\
source "$1"
function=$(complete -p tracerisk | grep -o -- '-F [^ ]*' | cut -d' ' -f2)
shift
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
$function tracerisk "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture(scope="module")
def script(tmp_path_factory, example_in):
    example = example_in(tmp_path_factory.mktemp("completion"))
    outcome = example.run("completion", "bash")
    assert outcome.code == 0, outcome.err
    return example.write("completion.bash", outcome.out)


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ([""], set(VERBS)),
        (["ch"], {"check"}),
        (["diff", "--form"], {"--format"}),
        (["diff", "--format", ""], {"text", "markdown", "json"}),
        (["completion", ""], set(SHELLS)),
    ],
)
def test_bash_completes_verbs_options_and_choices(script, words, offered):
    found = subprocess.run(
        ["bash", "-c", COMPLETE, "bash", script, "tracerisk", *words],
        capture_output=True,
        text=True,
        check=True,
    )
    assert {word for word in found.stdout.split() if not word.startswith("-h")} - {
        "--help"
    } == offered


@pytest.mark.skipif(shutil.which("fish") is None, reason="needs fish")
@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("tracerisk ", set(VERBS)),
        ("tracerisk ch", {"check"}),
        ("tracerisk diff --form", {"--format"}),
        ("tracerisk diff --format ", {"text", "markdown", "json"}),
    ],
)
def test_fish_completes_verbs_options_and_choices(example, line, offered):
    script = example.write("tracerisk.fish", example.run("completion", "fish").out)
    found = subprocess.run(
        ["fish", "--no-config", "-c", 'source $argv[1]; complete -C "$argv[2]"', script, line],
        capture_output=True,
        text=True,
        check=True,
    )
    words = {each.partition("\t")[0] for each in found.stdout.splitlines()}
    assert words == offered


@pytest.mark.parametrize("shell", SHELLS)
def test_there_is_a_script_for_each_shell_that_knows_every_verb(example, shell):
    outcome = example.run("completion", shell)
    assert outcome.code == 0, outcome.err
    assert all(verb in outcome.out for verb in VERBS)
    assert "max-increase" in outcome.out
