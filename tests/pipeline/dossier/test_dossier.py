"""The dossier: solved by SCRAM, and recomputed from its text alone."""

import hashlib
import json
import math
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from tracerisk.cli import main

SCRAM = shutil.which("scram")
needs_scram = pytest.mark.skipif(SCRAM is None, reason="needs scram")
DIGITS = 3e-8  # relative; the calculation prints eight digits
SHARED = """\
def place(arm):
    # | RiskAnnotation
    # | @Function {
    # |   name = place
    # |   callSequence = 2
    # |   next = pick 6/7
    # |   next = done 1/7
    # | }
    # | @Component {
    # |   name = power
    # |   probability = 0.002
    # |   quantity = 3
    # |   redundancy = required 2, common_cause 0.1
    # | }
    # | @Component {
    # |   name = brake
    # |   probability = 0.01
    # |   quantity = 3
    # |   redundancy = required 1, detected each_visit
    # | }
    arm.place()


def pick(arm):
    # | RiskAnnotation
    # | @Function {
    # |   name = pick
    # |   callSequence = 1
    # |   next = place 1
    # | }
    # | @Component {
    # |   name = power
    # |   probability = 0.003
    # |   quantity = 3
    # |   redundancy = required 2, common_cause 0.1
    # | }
    # | @Component {
    # |   name = motor
    # |   probability = 0.001
    # |   quantity = 6
    # |   redundancy = false
    # | }
    arm.pick()
"""
SPARES = SHARED.replace("required 2, common_cause 0.1", "required 1, spare cold")


def unzipped(path: Path, folder: Path) -> Path:
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    return folder


@pytest.fixture(scope="module")
def of_run(short_run, tmp_path_factory):
    """The dossier of a run of the sample, unpacked."""
    example, _ = short_run
    outcome = example.run("report", "pick_and_place.py", "--dossier", "out.zip", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json["dossier"] == "out.zip"
    return unzipped(example.folder / "out.zip", tmp_path_factory.mktemp("dossier"))


@pytest.fixture
def of_blocks(tmp_path, monkeypatch):
    """Makes the dossier of blocks that no run is known of."""

    def make(source: str, name: str = "cell.py") -> Path:
        monkeypatch.chdir(tmp_path)
        (tmp_path / name).write_text(source)
        assert main(["report", name, "--dossier", "out.zip", "--quiet"]) == 0
        return unzipped(tmp_path / "out.zip", tmp_path / "unpacked")

    return make


def tables(text: str, *headings: str) -> list[list[str]]:
    """The rows of all tables in Markdown with these headings."""
    found, inside = [], False
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")] if "|" in line else []
        if cells == list(headings):
            inside = True
        elif not cells:
            inside = False
        elif inside and not set(line) <= set("|-"):
            found.append(cells)
    return found


def either(*parts: float) -> float:
    """1 - product of (1 - p), as one may do it by hand with enough digits."""
    return -math.expm1(math.fsum(math.log1p(-p) for p in parts))


def at_least(m: int, q: int, p: float) -> float:
    if m == 1:
        return either(*[p] * q)
    return math.fsum(math.comb(q, i) * p**i * (1.0 - p) ** (q - i) for i in range(m, q + 1))


VISIT = ("part", "units q", "fails at m failed", "p of a unit", "fails with")
RENEWED = ("function", "part", "N", "p of a visit", "fails over the mission")
LATENT = (
    *("component", "units q", "fails at m failed", "N_f x p_f of a unit"),
    *("one unit fails over the mission", "group fails over the mission"),
)


def check_visits(text: str) -> dict[str, float]:
    """Recompute the tables of functions; return the figure of each."""
    functions: dict[str, float] = {}
    parts: list[float] = []
    apart: list[float] = []
    for name, units, least, p, fails in reversed(tables(text, *VISIT)):
        # From the last row up, so that the parts of a row are known before it.
        if name.startswith("**"):
            parts, function = [], name.strip("*")
            functions[function] = float(fails)
            pending = parts
            continue
        if units:
            expected = at_least(int(least), int(units), float(p))
        else:
            expected = either(*apart)
        assert float(fails) == pytest.approx(expected, rel=DIGITS), name
        if name.startswith("- "):
            apart.append(float(fails))
            continue
        apart = []
        pending.append(float(fails))
        assert either(*pending) <= functions[function] * (1 + DIGITS)
        total = pending
        functions[f"sum of {function}"] = either(*total)
    for name in [name for name in functions if name.startswith("sum of ")]:
        function = name.removeprefix("sum of ")
        assert functions.pop(name) == pytest.approx(functions[function], rel=DIGITS), function
    return functions


def check_mission(text: str) -> float:
    """Recompute the mission from the tables of part 3; return its figure."""
    ways = []
    for _, name, visits, p, fails in tables(text, *RENEWED):
        assert float(fails) == pytest.approx(
            -math.expm1(float(visits) * math.log1p(-float(p))), rel=DIGITS
        ), name
        ways.append(float(fails))
    for name, units, least, shares, unit, group in tables(text, *LATENT):
        pairs = [tuple(map(float, share.split(" x "))) for share in shares.split(" + ")]
        over = -math.expm1(math.fsum(n * math.log1p(-p) for n, p in pairs))
        assert float(unit) == pytest.approx(over, rel=DIGITS), name
        expected = at_least(int(least), int(units), float(unit))
        assert float(group) == pytest.approx(expected, rel=3 * DIGITS), name
        ways.append(float(group))
    (figure,) = re.findall(r"over the mission\) = \*\*([^*]+)\*\*", text)
    assert float(figure) == pytest.approx(either(*ways), rel=DIGITS)
    return float(figure)


def check_blocks(text: str) -> dict[tuple[str, str], float]:
    """Recompute part 1 from rates and times; return what stands in the block of each component."""
    blocks = {}
    for function, body in re.findall(
        r"^### (\S+)\n\n```text\n(.*?)```", text, re.DOTALL | re.MULTILINE
    ):
        for component in re.split(r"\n\n", body)[1:]:
            name = component.partition(":")[0]
            p, rate = re.findall(r"probability (\S+) per minute: .* = (\S+) per s", component)[0]
            assert float(rate) == pytest.approx(-math.log1p(-float(p)) / 60.0, rel=DIGITS)
            head, visits = component.split("start [s]")
            rows = re.findall(
                r"^    (\S+)(?: \(x(\d+)\))? +([\d.e-]+)  +([\d.e-]+)$", head, re.MULTILINE
            )
            total = 0.0
            for row in re.findall(
                r"^    (.+?)(?: \(x(\d+)\))?  +([\d.e-]+)  +([\d.e-]+)$", head, re.MULTILINE
            ):
                _, count, seconds, hazard = row
                assert float(hazard) == pytest.approx(float(rate) * float(seconds), rel=1e-6)
                total += int(count or 1) * float(hazard)
            assert rows or total
            by_visit = re.findall(r"^    visit \d+ .* (\S+)$", visits, re.MULTILINE)
            assert math.fsum(map(float, by_visit)) == pytest.approx(total, rel=1e-6), name
            shown, over, value = re.findall(
                r"1 - exp\(-(\S+) / \(?([\d x]+)\)?\) = (\S+)", component
            )[0]
            assert float(shown) == pytest.approx(total, rel=1e-6), name
            count = math.prod(int(factor) for factor in over.split(" x "))
            assert float(value) == pytest.approx(-math.expm1(-total / count), rel=1e-6), name
            (block,) = re.findall(r"block: probability = (\S+)", component)
            assert float(block) == float(f"{float(value):.3e}"), name
            blocks[function, name] = float(block)
    return blocks


def test_each_figure_is_recomputed_from_the_text_alone(of_run):
    text = (of_run / "calculation.md").read_text()
    blocks = check_blocks(text)
    assert len(blocks) == 18
    in_source = (of_run / "files" / "pick_and_place.py").read_text()
    for (_, component), value in blocks.items():
        lines = rf"name = {component}\n.*probability = {re.escape(f'{value:.4g}')}\n"
        assert re.search(lines, in_source), (component, value)
    for function in re.split(r"^### ", text.partition("## 2.")[2], flags=re.MULTILINE)[1:]:
        name = function.split()[0]
        for part, *_, p, _ in tables(function, *VISIT)[:-1]:
            assert float(p) == blocks[name, part]
    functions = check_visits(text)
    assert list(functions) == ["place", "place_position", "pick", "pick_position", "init"]
    figure = check_mission(text)
    record = json.loads((of_run / "record.json").read_text())
    assert figure == pytest.approx(record["failure_probability"], rel=DIGITS)
    assert "That is the same figure." in text


COUNTED = "That is the same figure."
DRAWN = "because the numbers of cycles vary around their mean"


@pytest.mark.parametrize(
    ("source", "words"),
    [(SHARED, COUNTED), (SHARED.replace("6/7", "0.9").replace("1/7", "0.1"), DRAWN)],
)
def test_blocks_alone_are_recomputed_up_to_the_mission(of_blocks, source, words):
    text = (of_blocks(source) / "calculation.md").read_text()
    assert (
        "The blocks are taken as they stand in the sources. tracerisk.lock knows of no run" in text
    )
    assert set(check_visits(text)) == {"pick", "place"}
    check_mission(text)
    assert words in text


_BLOCK = """\
def {name}(arm):
    # | RiskAnnotation
    # | @Function {{
    # |   name = {name}
    # |   callSequence = {rank}
{following}
    # | }}
    # | @Component {{
    # |   name = motor
    # |   probability = {p}
    # |   quantity = 1
    # |   redundancy = false
    # | }}
    arm.go()


"""
_BRANCHING = {
    "main": (0.01, "reach 1"),
    "reach": (0.02, "grip 2/4", "let_go 2/4"),
    "grip": (0.03, "reach 1"),
    "let_go": (0.04, "reach 1/2", "done 1/2"),
}


def test_the_reason_of_a_difference_is_the_one_that_makes_it(of_blocks):
    source = "".join(
        _BLOCK.format(
            name=name,
            rank=rank,
            p=p,
            following="\n".join(f"    # |   next = {step}" for step in steps),
        )
        for rank, (name, (p, *steps)) in enumerate(_BRANCHING.items(), start=1)
    )
    text = (of_blocks(source) / "calculation.md").read_text()
    check_mission(text)
    assert "because a cycle counts the mean of the ways on which reach may go on" in text
    assert "hidden failures are carried" not in text


def scram(model: Path) -> dict[str, float]:
    done = subprocess.run(
        [SCRAM, "--probability", "1", str(model)], capture_output=True, text=True, check=True
    )
    rows = re.findall(r'sum-of-products name="([^"]*)"[^>]* probability="([^"]*)"', done.stdout)
    return {name: float(value) for name, value in rows}


def said(folder: Path) -> tuple[dict[str, float], float | None]:
    """What the guide says that SCRAM prints: of functions, and of the mission."""
    text = (folder / "README.md").read_text()
    rows = tables(text, "function", "fails in one visit")
    mission = re.findall(r"It must print (\S+): the mission", text)
    return {name: float(value) for name, value in rows}, float(mission[0]) if mission else None


@needs_scram
def test_scram_gives_what_the_guide_says(of_run):
    functions, mission = said(of_run)
    solved = scram(of_run / "model" / "functions.xml")
    assert {name.partition(".")[0]: value for name, value in solved.items()} == functions
    assert list(scram(of_run / "model" / "mission.xml").values()) == [mission]
    record = json.loads((of_run / "record.json").read_text())
    assert mission == pytest.approx(record["failure_probability"], rel=5e-6)


@needs_scram
def test_scram_solves_common_causes_and_votes_as_well(of_blocks):
    folder = of_blocks(SHARED)
    functions, mission = said(folder)
    solved = scram(folder / "model" / "functions.xml")
    assert {name.partition(".")[0]: value for name, value in solved.items()} == functions
    assert list(scram(folder / "model" / "mission.xml").values()) == [mission]


@needs_scram
def test_the_commands_of_the_guide_run(of_run):
    text = (of_run / "README.md").read_text()
    commands = [
        command
        for command in re.findall(r"^```sh\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
        if command.startswith(("sha256sum", "scram"))
    ]
    assert len(commands) == 3
    for command in commands:
        done = subprocess.run(
            ["/bin/sh", "-ec", command], cwd=of_run, capture_output=True, text=True, check=True
        )
        assert done.stdout


def test_every_file_has_its_digest_and_is_what_the_record_names(of_run):
    listed = dict(
        reversed(line.split("  ", 1)) for line in (of_run / "SHA256SUMS").read_text().splitlines()
    )
    there = {
        path.relative_to(of_run).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in of_run.rglob("*")
        if path.is_file() and path.name != "SHA256SUMS"
    }
    assert listed == there
    record = json.loads((of_run / "record.json").read_text())
    for file in record["files"]:
        assert listed[f"files/{file['path']}"] == file["sha256"]
    assert {file["role"] for file in record["files"]} >= {"source", "lock", "hardware"}


def test_spares_are_no_static_tree_and_the_guide_says_so(of_blocks):
    folder = of_blocks(SPARES)
    assert not (folder / "model" / "mission.xml").exists()
    assert "The mission is no static fault tree" in (folder / "README.md").read_text()
    text = (folder / "calculation.md").read_text()
    assert "it has spares, which fail at another rate once they work" in text


def test_without_a_run_nothing_is_said_of_the_failure_data(of_blocks):
    assumptions = (of_blocks(SPARES) / "assumptions.md").read_text()
    assert "data without a source\n\nNot known: the run is not in this dossier." in assumptions


def test_each_page_with_the_figure_says_where_no_run_stands_behind_it(of_blocks):
    folder = of_blocks(SPARES)
    for page in ("README.md", "assumptions.md", "sheet.md"):
        assert "**Do not use the figures of this dossier**" in (folder / page).read_text()
    rows = dict(tables((folder / "README.md").read_text(), "what", "how it was established"))
    for what in ("the risk blocks", "sources, settings and other inputs"):
        assert rows[what] == "**on trust**: no lock says of which run they are"


def test_the_same_report_gives_the_same_bytes(of_blocks, tmp_path):
    of_blocks(SHARED)
    first = (tmp_path / "out.zip").read_bytes()
    of_blocks(SHARED)
    assert (tmp_path / "out.zip").read_bytes() == first


def test_components_with_a_common_cause_are_counted_once(of_blocks, capsys):
    of_blocks(SHARED)
    assert main(["build", "cell.py", "-o", "model.json"]) == 0
    assert "2 functions, 2 fault trees, 3 components" in capsys.readouterr().err


def test_a_file_above_the_root_stays_within_the_archive(of_blocks, tmp_path):
    (tmp_path.parent / "own.yaml").write_text(
        "components:\n  power: {probability: {value: 1e-6, per: minute}, active: always}\n"
    )
    (tmp_path / "cell.py").write_text(SHARED)
    (tmp_path / "pyproject.toml").write_text('[tool.tracerisk]\nhardware = "../own.yaml"\n')
    folder = of_blocks(SHARED)
    assert (folder / "files" / "outside" / "own.yaml").is_file()


HARDWARE = "components:\n  power: {probability: {value: 1e-6, per: minute}, active: always}\n"


@pytest.fixture(scope="module")
def with_own_hardware(example_in, quick, tmp_path_factory):
    """A folder in which a controller was run with a hardware description beside it."""
    example = example_in(tmp_path_factory.mktemp("own"))
    example.write("pyproject.toml", '[tool.tracerisk]\nhardware = "cell.yaml"\n')
    example.write("cell.yaml", HARDWARE)
    example.write("controller.py", quick())
    outcome = example.run("run", "controller.py", "--quiet")
    assert outcome.code == 0, outcome.err
    return example.folder


def test_the_remedy_of_a_kept_run_that_was_edited_mends_it(example, quick):
    example.write("pyproject.toml", '[tool.tracerisk]\nhardware = "cell.yaml"\n')
    example.write(
        "cell.yaml",
        "source: data book\ncomponents:\n"
        "  motor: {probability: {value: 1e-6, per: demand, of: start}, twin: {joints: '*'}}\n",
    )
    example.write("controller.py", quick())
    dossier = ("report", "controller.py", "--dossier", "out.zip")
    assert example.run("run", "controller.py", "--quiet").code == 0
    assert example.run(*dossier).code == 0
    with zipfile.ZipFile(example.folder / "out.zip") as archive:
        assert "source: data book" in archive.read("calculation.md").decode()
    (path,) = (example.folder / ".tracerisk_cache").glob("*.json")
    trace = json.loads(path.read_bytes())
    for visit in trace["visits"]:
        for exposure in visit["exposures"].values():
            exposure["starts"] = 0
    path.write_text(json.dumps(trace))
    refused = example.run(*dossier)
    assert refused.code == 2
    assert "`tracerisk run controller.py` makes both again" in refused.err
    assert example.run("run", "controller.py", "--quiet").code == 0
    assert example.run(*dossier).code == 0


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("file", "old", "new", "code", "why"),
    [
        ("cell.yaml", "1e-6", "2e-6", 1, "stale: cell.yaml has changed since the last run"),
        ("controller.py", "\ndef ", "\nprint(1)\n\n\ndef ", 1, "controller.py has changed"),
        ("controller.py", "probability = ", "probability = 9", 3, "edited: "),
        ("pyproject.toml", "[tool.tracerisk]", "[tool.tracerisk]\nseed = 9", 1, "setting seed"),
    ],
)
def test_no_dossier_of_a_figure_that_its_files_do_not_give(
    with_own_hardware, example_in, tmp_path, file, old, new, code, why
):
    example = example_in(Path(shutil.copytree(with_own_hardware, tmp_path / "cell")))
    fine = example.run("report", "controller.py", "--dossier", "fine.zip")
    assert (fine.code, (example.folder / "fine.zip").is_file()) == (0, True), fine.err
    assert example.run("report", "controller.py", "-o", "page.html", "--quiet").code == 0
    fine_page = example.read("page.html").decode()
    path = example.folder / file
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new, 1))
    outcome = example.run("report", "controller.py", "--dossier", "out.zip", "-o", "out.html")
    assert outcome.code == code, outcome.err
    assert why in outcome.err
    assert "`tracerisk refresh controller.py`" in outcome.err
    assert "out.zip: not written: the figure does not follow from the files in it" in outcome.err
    assert not list(example.folder.glob("out.*"))
    page = example.run("report", "controller.py", "-o", "page.html", "--quiet")
    assert page.code == 0, page.err
    kind = why.partition(":")[0] if ":" in why else "stale"
    assert f'<p class="aside">{kind}: ' in example.read("page.html").decode()
    assert '<p class="aside">stale: ' not in fine_page
    data = example.run("report", "controller.py", "--dossier", "out.zip", "--json").json
    assert [finding["kind"] for finding in data["findings"]] == ["edited" if code == 3 else "stale"]


def test_the_commands_make_the_same_archive_from_the_files_in_it(
    with_own_hardware, example_in, tmp_path
):
    example = example_in(Path(shutil.copytree(with_own_hardware, tmp_path / "cell")))
    words = ("report", "controller.py", "--dossier", "dossier.zip")
    outcome = example.run(*words)
    assert outcome.code == 0, outcome.err
    data = example.read("dossier.zip")
    digest = hashlib.sha256(data).hexdigest()
    assert f"dossier.zip: the dossier of controller.py, SHA-256 {digest}" in outcome.err
    assert example.run(*words, "--json").json["dossier_sha256"] == digest
    folder = unzipped(example.folder / "dossier.zip", tmp_path / "unpacked")
    text = (folder / "README.md").read_text().partition("## Make it again")[2]
    (commands,) = re.findall(r"^```sh\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    assert "files are copied from here first" in text
    install, *copies, run, report = commands.splitlines()
    assert install.startswith("pip install --constraint DOSSIER/constraints.txt '")
    assert "mujoco==" in (folder / "constraints.txt").read_text()
    elsewhere = example_in(tmp_path / "elsewhere")
    elsewhere.folder.mkdir()
    for command in copies:
        subprocess.run(
            ["/bin/sh", "-ec", command.replace("DOSSIER", str(folder))],
            cwd=elsewhere.folder,
            check=True,
        )
    for command in (run, report):
        outcome = elsewhere.run(*command.split()[1:], "--quiet")
        assert outcome.code == 0, outcome.err
    assert elsewhere.read("dossier.zip") == data


def test_a_figure_of_another_mission_than_the_run_has_no_rate_per_hour(
    with_own_hardware, example_in, tmp_path
):
    example = example_in(Path(shutil.copytree(with_own_hardware, tmp_path / "cell")))
    source = example.read("controller.py").decode()
    (line, indent) = re.search(r"(( *# \|   )next = done 1\n)", source).groups()
    often = f"{indent}next := act 9/10  ! ten rounds\n{indent}next := done 1/10\n"
    example.write("controller.py", source.replace(line, often))
    outcome = example.run("report", "controller.py", "--dossier", "out.zip")
    assert outcome.code == 0, outcome.err
    text = (unzipped(example.folder / "out.zip", tmp_path / "unpacked") / "README.md").read_text()
    assert "| mean rate | none: the figure is of a mission that visits " in text
    assert "per hour = -ln" not in text


def test_the_guide_has_band_duration_rate_and_versions(with_own_hardware, example_in, tmp_path):
    example = example_in(Path(shutil.copytree(with_own_hardware, tmp_path / "cell")))
    example.write("cell.yaml", HARDWARE.replace("minute}", "minute, error_factor: 3}"))
    outcome = example.run("refresh", "controller.py", "--quiet")
    assert outcome.code == 0, outcome.err
    assert example.run("report", "controller.py", "--dossier", "out.zip").code == 0
    folder = unzipped(example.folder / "out.zip", tmp_path / "unpacked")
    text = (folder / "README.md").read_text()
    record = json.loads((folder / "record.json").read_text())
    facts = dict(re.findall(r"^\| ([^|]+) \| (.+) \|$", text, re.MULTILINE))
    assert facts["band"] == record["band"]
    assert record["band"].startswith("With 90 % probability that figure lies between ")
    assert "by the error factors of power in 2,000 samples" in record["band"]
    seconds = float(facts["duration of the mission T"].removesuffix(" s"))
    trace = json.loads((folder / "trace.json").read_text())
    assert seconds == pytest.approx(trace["end"]["simulated_s"], rel=DIGITS)
    rate = float(facts["mean rate"].partition(" ")[0])
    risk = record["failure_probability"]
    assert rate == pytest.approx(-math.log1p(-risk) / (seconds / 3600.0), rel=1e-3)
    assert record["environment"]["packages"]["mujoco"] in facts["made with"]
    assert facts["how the run ended"] == trace["end"]["message"]
    assert facts["mission by `success`"].startswith("**nothing declares it**")
    assert "figures of this dossier" not in text
    assert ("No package index has version" in text) is (".dev" in facts["tracerisk"])
    assumed = (folder / "assumptions.md").read_text()
    assert "\n- in use but not counted, as the hardware data has no figures for them: " in assumed
    assert (
        "## Failure data without a source\n\n- power (100 % of the figure): no source is given\n\n"
        in assumed
    )
    assert "error factor 3" in (folder / "calculation.md").read_text()
    steps = tables(
        (folder / "sheet.md").read_text(),
        *("no.", "step", "done or why not", "result, and where it is kept", "by, on"),
    )
    assert [row[0] for row in steps] == [str(number) for number in range(1, 13)]


def test_no_dossier_with_hardware_that_its_blocks_were_not_computed_with(
    with_own_hardware, example_in, tmp_path
):
    example = example_in(Path(shutil.copytree(with_own_hardware, tmp_path / "cell")))
    example.write("other.yaml", HARDWARE)
    words = ("report", "controller.py", "--dossier", "out.zip")
    outcome = example.run(*words, "--hardware", "other.yaml")
    assert outcome.code == 2
    assert "its blocks were not computed with this --hardware; leave it out" in outcome.err
    outcome = example.run(*words, "--hardware", "cell.yaml")
    assert outcome.code == 0, outcome.err


def test_no_dossier_of_another_mission_than_its_blocks_state(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cell.py").write_text(SHARED)
    words = ["report", "cell.py", "--profile", "place:pick=0.1,done=0.9"]
    assert main([*words, "--dossier", "out.zip"]) == 2
    assert "cell.py: a dossier has the figure of the blocks in it" in capsys.readouterr().err
    assert not (tmp_path / "out.zip").exists()
    assert main([*words, "--output", "out.html"]) == 0
    said = "--profile gives other shares than the block of place, so another mission"
    assert said in (tmp_path / "out.html").read_text()


def weaker(trace: dict) -> None:
    trace["end"]["simulated_s"] *= 0.1
    for visit in trace["visits"]:
        visit["start_s"] *= 0.1
        visit["duration_s"] *= 0.1
        for exposure in visit["exposures"].values():
            for key in [key for key in exposure if key.endswith("_s") and exposure[key]]:
                exposure[key] *= 0.1


def faulted(trace: dict) -> None:
    trace["verdict"]["kind"] = "faulted"


def shorter(trace: dict) -> None:
    trace["end"]["simulated_s"] *= 0.5


def shorter_visits(trace: dict) -> None:
    for visit in trace["visits"]:
        visit["duration_s"] *= 0.9


def unmet(trace: dict) -> None:
    trace["success"] = [{"words": "called /weigh 2 times", "is_met": False}]


def elsewhere(trace: dict) -> None:
    trace["outcome"]["rests"][0]["tool_m"][2] += 0.1
    trace["outcome"]["rests"][0]["joints"][0] += 0.1


def less_in_use(trace: dict) -> None:
    # By half a percent and more: what is less, a lock may have kept from a run before.
    for visit in trace["visits"]:
        for exposure in visit["exposures"].values():
            for key in [key for key in exposure if key.endswith("_s") and exposure[key]]:
                exposure[key] *= 0.99


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("change", "why"),
    [
        (weaker, "differ in the durations of its visits"),
        (faulted, "the kept trace of its last run and tracerisk.lock differ in the verdict"),
        (shorter, "differ in the length"),
        (shorter_visits, "differ in the durations of its visits"),
        (less_in_use, "differ in the times in use of its elements"),
        (unmet, "differ in the conditions of `success` that were not met"),
        (elsewhere, "differ in the outcome"),
    ],
)
def test_no_dossier_of_a_run_that_the_blocks_and_the_lock_do_not_follow_from(
    with_own_hardware, example_in, tmp_path, change, why
):
    example = example_in(Path(shutil.copytree(with_own_hardware, tmp_path / "cell")))
    (cached,) = (example.folder / ".tracerisk_cache").glob("*.json")
    trace = json.loads(cached.read_text())
    change(trace)
    cached.write_text(json.dumps(trace))
    for option, name in (("--dossier", "out.zip"), ("--output", "out.html")):
        outcome = example.run("report", "controller.py", option, name)
        assert outcome.code == 2, outcome.err
        assert why in " ".join(outcome.err.split())
        assert not (example.folder / name).exists()


def test_no_dossier_where_the_lock_says_other_times_than_the_run(
    with_own_hardware, example_in, tmp_path
):
    example = example_in(Path(shutil.copytree(with_own_hardware, tmp_path / "cell")))
    lock = json.loads((example.folder / "tracerisk.lock").read_text())
    (entry,) = lock["controllers"].values()
    for function in entry["trace"]["functions"].values():
        function["duration_s"] *= 0.5
    example.write("tracerisk.lock", json.dumps(lock))
    outcome = example.run("report", "controller.py", "--dossier", "out.zip")
    assert outcome.code == 2, outcome.err
    assert "differ in the durations of its visits" in " ".join(outcome.err.split())


def test_a_dossier_says_what_was_recomputed_and_what_was_taken_on_trust(
    with_own_hardware, example_in, tmp_path
):
    example = example_in(Path(shutil.copytree(with_own_hardware, tmp_path / "cell")))
    assert example.run("report", "controller.py", "--dossier", "out.zip").code == 0
    text = (unzipped(example.folder / "out.zip", tmp_path / "one") / "README.md").read_text()
    rows = dict(tables(text, "what", "how it was established"))
    assert rows["the risk blocks"].startswith("recomputed from `trace.json`")
    assert rows["the run, `trace.json`"].startswith("compared with `tracerisk.lock`")
    assert rows["that the run is one of these inputs"].startswith("**on trust**")
    established = rows["the duration of the mission T"]
    assert established.startswith("compared with `tracerisk.lock`: no longer than the visits")
    rate = dict(tables(text, "", ""))["mean rate"].partition(" ")[0]

    (cached,) = (example.folder / ".tracerisk_cache").glob("*.json")
    trace = json.loads(cached.read_text())
    seconds = trace["end"]["simulated_s"]
    trace["end"]["simulated_s"] *= 10.0
    cached.write_text(json.dumps(trace))
    assert example.run("report", "controller.py", "--dossier", "out.zip").code == 0
    text = (unzipped(example.folder / "out.zip", tmp_path / "two") / "README.md").read_text()
    rows = dict(tables(text, "what", "how it was established"))
    (rest,) = re.findall(
        r"\*\*on trust\*\* for (\S+) s of it", rows["the duration of the mission T"]
    )
    assert float(rest) == pytest.approx(9.0 * seconds, rel=1e-3)
    facts = dict(tables(text, "", ""))
    assert f"**on trust** for {rest} s of it" in facts["duration of the mission T"]
    assert facts["mean rate"].partition(" ")[0] == rate
    assert " s of the visits as T; " in facts["mean rate"]

    cached.unlink()
    assert example.run("report", "controller.py", "--dossier", "out.zip").code == 0
    text = (unzipped(example.folder / "out.zip", tmp_path / "three") / "README.md").read_text()
    rows = dict(tables(text, "what", "how it was established"))
    assert rows["the risk blocks"].startswith("**on trust**")
    assert "the run, `trace.json`" not in rows


def test_a_trace_of_other_sources_is_refused(with_own_hardware, example_in, tmp_path):
    example = example_in(Path(shutil.copytree(with_own_hardware, tmp_path / "cell")))
    (cached,) = (example.folder / ".tracerisk_cache").glob("*.json")
    trace = json.loads(cached.read_text())
    weaker(trace)
    example.write("other.json", json.dumps(trace))
    options = ("report", "controller.py", "--trace", "other.json", "--dossier", "out.zip")
    outcome = example.run(*options)
    assert outcome.code == 2, outcome.err
    assert "the run is of other sources" in " ".join(outcome.err.split())

    example.write("same.json", cached.read_text())
    outcome = example.run(*(option.replace("other.json", "same.json") for option in options))
    assert outcome.code == 0, outcome.err
    text = (unzipped(example.folder / "out.zip", tmp_path / "out") / "README.md").read_text()
    rows = dict(tables(text, "what", "how it was established"))
    assert rows["the run, `trace.json`"].startswith("**on trust**")
    assert "the duration of the mission T" not in rows


@pytest.mark.slow
def test_the_guide_runs_the_controller_and_not_one_of_its_modules(example_in, quick, tmp_path):
    example = example_in(tmp_path)
    example.write("pyproject.toml", "")
    example.write("arm_steps.py", "def steady(step):\n    return step\n")
    source = quick("from arm_steps import steady", "steady(1)")
    example.write("turn.py", source)
    assert example.run("run", "turn.py", "--quiet").code == 0
    assert example.run("report", "turn.py", "--dossier", "out.zip").code == 0
    guide = (unzipped(tmp_path / "out.zip", tmp_path / "unpacked") / "README.md").read_text()
    assert "tracerisk run turn.py\n" in guide
