import pytest

from tracerisk.common.settings.project_settings import ProjectSettings
from tracerisk.config import Settings, controller_root
from tracerisk.errors import SettingsError


def write(root, body: str) -> None:
    (root / "pyproject.toml").write_text(f"[project]\nname = 'x'\n\n[tool.tracerisk]\n{body}\n")


def test_defaults_where_there_is_no_table(tmp_path):
    assert ProjectSettings(tmp_path).of() == Settings()
    (tmp_path / "pyproject.toml").write_text("[project]\nname = 'x'\n")
    assert ProjectSettings(tmp_path).of() == Settings()


def test_settings_are_read_and_options_override_them(tmp_path):
    write(tmp_path, 'active = "moving"\nduration_s = 20\nhelpers = ["go_to"]')
    settings = ProjectSettings(tmp_path).of()
    assert settings == Settings(active="moving", duration_s=20.0, helpers=("go_to",))
    assert settings.with_options({"active": "moving+holding", "seed": None}) == Settings(
        duration_s=20.0, helpers=("go_to",)
    )


def test_a_named_file_of_the_root_becomes_its_path(tmp_path):
    (tmp_path / "arm.yaml").write_text("")
    write(tmp_path, 'hardware = "arm.yaml"\nrobot = "panda"')
    settings = ProjectSettings(tmp_path).of()
    assert settings.hardware == str(tmp_path / "arm.yaml")
    assert settings.robot == "panda"


BAD = {
    'actve = "moving"': "5: actve: unknown setting; did you mean 'active'?",
    'seed = 1\nactive = "still"': "6: active: 'still' is not allowed; allowed: moving",
    'fail_on = "findings"': "5: fail_on: 'findings' is not allowed; did you mean 'finding'?",
    "duration_s = -1": "5: duration_s: expected a number above 0, found -1",
    "duration_s = true": "expected a number above 0",
    "tolerance = -0.1": "tolerance: expected a number from 0 to 0.05, found -0.1",
    "tolerance = 0.06": "tolerance: expected a number from 0 to 0.05, found 0.06",
    "tolerance = true": "tolerance: expected a number from 0 to 0.05, found True",
    'blocks = "short"': "blocks: 'short' is not allowed; allowed: compact, published",
    "seed = 1.5": "expected a whole number",
    "robot = 3": "expected a string",
    "states = ['a', 'b']\nhelpers = ['b']": "6: helpers: b stands in `states` too; keep it in one",
    "states = 'a'": "expected a list of qualified names",
    "seed = ": "is not valid TOML",
}


@pytest.mark.parametrize(("body", "message"), BAD.items())
def test_a_bad_setting_is_an_error_with_file_and_line(tmp_path, body, message):
    write(tmp_path, body)
    with pytest.raises(SettingsError) as caught:
        ProjectSettings(tmp_path).of()
    assert message in str(caught.value)
    assert "pyproject.toml" in str(caught.value)


OWN = """\
#!/usr/bin/env python3
# /// script
# dependencies = []
#
# [tool.tracerisk]
# SETTING
# ///
print("moves an arm")
"""


def carrying(setting: str) -> str:
    """A controller that carries a setting of its own."""
    return OWN.replace("SETTING", setting)


def test_a_controller_carries_settings_of_its_own_which_go_before_all_others(tmp_path):
    (tmp_path / "pick.py").write_text(carrying('scene = "tube_racks"'))
    (tmp_path / "place.py").write_text("")
    body = 'scene = "pedestal"\nseed = 4\n[tool.tracerisk.controllers."pick.py"]\nscene = "floor"'
    write(tmp_path, body)
    assert ProjectSettings(tmp_path).of("pick.py") == Settings(scene="tube_racks", seed=4)
    assert ProjectSettings(tmp_path).of("place.py") == Settings(scene="pedestal", seed=4)
    origin = ProjectSettings(tmp_path).origins("pick.py")["scene"]
    assert origin.is_own
    assert str(origin.location) == f"{tmp_path / 'pick.py'}:6"


def test_a_controller_carries_its_settings_where_there_is_no_other_file(tmp_path):
    (tmp_path / "pick.py").write_bytes(carrying('scene = "tube_racks"').encode())
    assert ProjectSettings(tmp_path).of("pick.py").scene == "tube_racks"
    windows = carrying('scene = "tube_racks"').replace("\n", "\r\n")
    (tmp_path / "pick.py").write_bytes(b"\xef\xbb\xbf" + windows.encode())
    assert ProjectSettings(tmp_path).of("pick.py").scene == "tube_racks"


def test_names_of_files_in_a_controller_start_from_its_folder(tmp_path):
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "cell.yaml").write_text("")
    (tmp_path / "src" / "pick.py").write_text(carrying('scene = "cell.yaml"'))
    write(tmp_path, "")
    settings = ProjectSettings(tmp_path).of("src/pick.py")
    assert settings.scene == str(tmp_path / "src" / "cell.yaml")


@pytest.mark.parametrize(
    "text",
    [
        "print('no block')\n",
        "# /// script\n# dependencies = []\n# ///\n",
        "def f():\n    # /// script\n    # [tool.tracerisk]\n    # seed = 1\n    # ///\n    pass\n",
        "# /// script\n# dependencies = []\nprint('not closed, and nothing of ours')\n",
    ],
)
def test_what_is_no_block_of_settings_gives_none(tmp_path, text):
    (tmp_path / "pick.py").write_text(text)
    assert ProjectSettings(tmp_path).of("pick.py") == Settings()


BAD_OWN = {
    carrying('scenes = "empty"'): "pick.py:6: scenes: unknown setting; did you mean 'scene'?",
    carrying("seed = -1"): "pick.py:6: seed: expected a whole number from 0 up, found -1",
    carrying("seed = "): "is not valid TOML",
    carrying("seed = 1").replace(
        "# ///\n", "\n"
    ): "pick.py:2: the block '# /// script' has no end; put a line '# ///' below the settings",
    carrying("seed = 1") * 2: "pick.py:10: a second block '# /// script'; keep one",
    carrying('controllers = {"a.py" = {seed = 1}}'): "pick.py:6: controllers: a controller holds "
    "settings of itself alone",
}


@pytest.mark.parametrize(("text", "message"), BAD_OWN.items())
def test_a_bad_setting_in_a_controller_is_an_error_with_its_line(tmp_path, text, message):
    (tmp_path / "pick.py").write_text(text)
    with pytest.raises(SettingsError) as caught:
        ProjectSettings(tmp_path).of("pick.py")
    assert message in str(caught.value)
    assert "pick.py" in str(caught.value)


@pytest.mark.parametrize("mark", ["package.xml", "pyproject.toml", "setup.py", ".git"])
def test_root_is_the_nearest_marked_folder_else_the_scripts_own(tmp_path, mark):
    package = tmp_path / "ws" / "pkg"
    (package / "scripts").mkdir(parents=True)
    script = package / "scripts" / "arm.py"
    assert controller_root(script) == package / "scripts"
    (package / mark).touch()
    assert controller_root(script) == package


def test_a_controller_has_settings_of_its_own(tmp_path):
    (tmp_path / "src").mkdir()
    (tmp_path / "src/pick.py").write_text("")
    (tmp_path / "pyproject.toml").write_text(
        '[tool.tracerisk]\nrobot = "panda"\nmax_failure_probability = 1e-4\n\n'
        '[tool.tracerisk.controllers."src/pick.py"]\nrobot = "ur5e"\nargs = ["--left"]\n'
    )
    shared = ProjectSettings(tmp_path).of()
    assert (shared.robot, shared.args, shared.max_failure_probability) == ("panda", (), 1e-4)
    own = ProjectSettings(tmp_path).of("src/pick.py")
    assert (own.robot, own.args, own.max_failure_probability) == ("ur5e", ("--left",), 1e-4)
    assert ProjectSettings(tmp_path).of("src/other.py") == shared


@pytest.mark.parametrize("data", [b"\xff\xfe", b"[tool\n"])
def test_what_is_no_toml_is_reported(tmp_path, data):
    (tmp_path / "pyproject.toml").write_bytes(data)
    with pytest.raises(SettingsError, match=r"pyproject\.toml: is not valid TOML: "):
        ProjectSettings(tmp_path).of()


def test_tools_that_are_no_table_settle_nothing(tmp_path):
    (tmp_path / "pyproject.toml").write_text("tool = 3\n")
    assert ProjectSettings(tmp_path).of() == Settings()


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ('[tool.tracerisk.controllers."a.py"]\nrobo = "x"\n', 2, "unknown setting; did you mean"),
        ('[tool.tracerisk.controllers."b.py"]\nseed = 1\n', 1, "there is no controller b.py"),
        ("[tool.tracerisk]\ncontrollers = 3\n", 2, "expected tables"),
        ("[tool.tracerisk]\nmax_failure_probability = 2\n", 2, "a probability from 0 to 1"),
        ("[tool.tracerisk]\nrequire_reason = 1\n", 2, "expected true or false"),
        ('[tool.tracerisk]\nargs = "x"\n', 2, "expected a list of strings"),
    ],
)
def test_what_is_wrong_in_a_table_is_reported_with_its_line(tmp_path, text, line, message):
    (tmp_path / "a.py").write_text("")
    (tmp_path / "pyproject.toml").write_text(text)
    with pytest.raises(SettingsError, match=message) as caught:
        ProjectSettings(tmp_path).of("a.py")
    assert caught.value.location.line == line


def test_settings_that_nest_too_deeply_are_an_error_with_their_file(tmp_path):
    write(tmp_path, "states = " + "[" * 100_000)
    with pytest.raises(SettingsError, match=r"pyproject.toml: .*nests too deeply"):
        ProjectSettings(tmp_path).of()


@pytest.mark.parametrize("key", ["robot", "scene", "scenario", "hardware"])
def test_a_name_that_is_too_long_for_a_file_is_a_name(tmp_path, key):
    write(tmp_path, f'{key} = "{"p" * 5000}"')
    assert getattr(ProjectSettings(tmp_path).of(), key) == "p" * 5000


def test_the_home_of_a_user_who_is_not_there_stays_as_it_is_written(tmp_path):
    write(tmp_path, 'readable = ["~nobody-of-this-name/data"]')
    assert ProjectSettings(tmp_path).of().readable == (str(tmp_path / "~nobody-of-this-name/data"),)
