"""The commands that a package installs, as its files list them."""

from tracerisk.pipeline.workspace.console_scripts import ConsoleScript, console_scripts


def test_the_commands_of_all_three_files_are_listed(tmp_path):
    (tmp_path / "setup.py").write_text(
        "scripts = ['pick = cell.pick:main', f'{name} = cell.place:run']\n"
    )
    (tmp_path / "setup.cfg").write_text(
        "[options.entry_points]\nconsole_scripts =\n    hold=cell.hold:main"
    )
    (tmp_path / "pyproject.toml").write_text('[project.scripts]\nopen = "cell.tools.open:main"\n')
    assert list(console_scripts(tmp_path)) == [
        ConsoleScript("pick", "pick", "main", "setup.py"),
        ConsoleScript("", "place", "run", "setup.py"),
        ConsoleScript("hold", "hold", "main", "setup.cfg"),
        ConsoleScript("open", "open", "main", "pyproject.toml"),
    ]


def test_what_is_no_list_of_commands_names_none(tmp_path):
    assert list(console_scripts(tmp_path)) == []
    (tmp_path / "setup.py").write_bytes(b"\xff\xfe = ")
    (tmp_path / "pyproject.toml").write_text("[project]\nscripts = 3\n")
    assert list(console_scripts(tmp_path)) == []
    (tmp_path / "pyproject.toml").write_text("[project\n")
    assert list(console_scripts(tmp_path)) == []
