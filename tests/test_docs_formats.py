"""What docs/formats.md shows of Open-PSA, OpenPRA and the command is what happens."""

import doctest
import re
from importlib import import_module
from pathlib import Path

import pytest

TEXT = (Path(__file__).parent.parent / "docs" / "formats.md").read_text(encoding="utf-8")


def test_each_function_stands_in_a_module_named_beside_it():
    lines = re.findall(r"^`tracerisk\.[a-z_.]+`: .*", TEXT, re.MULTILINE)
    assert len(lines) > 5
    for line in lines:
        modules = [import_module(name) for name in re.findall(r"`(tracerisk[a-z_.]+)`", line)]
        for name in re.findall(r"`([a-z_]+)\(", line):
            assert any(hasattr(module, name) for module in modules), name


@pytest.mark.parametrize(
    ("section", "language", "name"),
    [("Open-PSA", "xml", "OPEN_PSA"), ("OpenPRA", "json", "OPENPRA")],
)
def test_the_examples_of_a_format_run_with_the_output_that_they_show(section, language, name):
    part = TEXT.split(f"\n## {section}\n")[1].split("\n## ")[0]
    (file,) = re.findall(rf"^```{language}\n(.*?)^```$", part, re.MULTILINE | re.DOTALL)
    (code,) = re.findall(r"^```python\n(.*?)^```$", part, re.MULTILINE | re.DOTALL)
    test = doctest.DocTestParser().get_doctest(code, {name: file}, "docs/formats.md", None, 0)
    runner = doctest.DocTestRunner(verbose=False)
    reported: list[str] = []
    runner.run(test, out=reported.append)
    assert runner.tries > 3
    assert runner.failures == 0, "".join(reported)


def test_the_commands_print_what_is_shown(tmp_path, monkeypatch, capfd):
    from tracerisk.cli import main

    xml = TEXT.split("\n## Open-PSA\n")[1]
    monkeypatch.chdir(tmp_path)
    Path("cooling.xml").write_text(xml.split("```xml\n")[1].split("```")[0], encoding="utf-8")
    part = TEXT.split("\n## On the command line\n")[1].split("\n## ")[0]
    shown = re.findall(r"^```console\n\$ (.*)\n([^`]*)^```$", part, re.MULTILINE)
    assert len(shown) == 4
    for command, expected in shown:
        main(command.split()[1:])
        out, err = capfd.readouterr()
        assert out + err == expected, command
