"""Replay and timeline in a browser: they show what the run did, and one cursor moves both."""

import base64
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from markupsafe import Markup

from tracerisk.common import trace_json
from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.shipped import hardware_of
from tracerisk.common.traced.elements import Contact
from tracerisk.common.traced.findings import Finding
from tracerisk.pipeline.pictures.run_section import recorded_run
from tracerisk.report.html.page import page as page_text
from tracerisk.report.html.run.recorded_replay import make_replay
from tracerisk.report.html.run.replay import RecordedRun, Replay
from tracerisk.report.html.run.replay_model import bodies_data, scene_bodies
from tracerisk.report.html.run.risk_shares import RISK
from tracerisk.report.html.run.timeline import timeline_section
from tracerisk.report.html.run.timeline_segments import GRASPING, HOLDING, MOVING, SOMEWHEN
from tracerisk.report.html.section import Data, Section
from tracerisk.trace import Trace
from tracerisk.twin.faults.fault import Fault
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot, robot_names

_SERIOUS = ("serious", "critical")
TIMES = (0.0, 3.32, 7.88, 20.04)
N_VISITS = 10

_READY = """
const done = arguments[0];
tracerisk.replay.ready.then(() => requestAnimationFrame(() => done("ready")), (e) => done(`${e}`));
"""
_GO_TO = """
const [time, done] = arguments;
const begun = tracerisk.replay.drawn;
tracerisk.clock.set(time, "test");
const look = () => (tracerisk.replay.drawn > begun ? done(true) : requestAnimationFrame(look));
tracerisk.clock.time === time && begun ? setTimeout(look, 0) : look();
"""
_PIXELS = """
const canvas = document.getElementById("replay-canvas");
const gl = canvas.getContext("webgl2");
const bytes = new Uint8Array(canvas.width * canvas.height * 4);
gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
const text = Array.from(bytes, (value) => String.fromCharCode(value)).join("");
return [canvas.height, canvas.width, btoa(text)];
"""
_CHART = """
const chart = document.querySelector(".timeline-chart");
const all = (selector) => [...chart.querySelectorAll(selector)];
return {
  visits: all(".timeline-visit").length,
  lanes: all(".timeline-name.is-function").map((each) => each.textContent),
  lines: Object.fromEntries(all(".timeline-line").map((line) => [
    line.dataset.line,
    [...line.querySelectorAll(".timeline-segment")].map((each) => Number(each.dataset.state)),
  ])),
};
"""
_RESET = """
tracerisk.player.pause();
tracerisk.clock.set(0, "test");
tracerisk.select({});
tracerisk.timeline.show(0, tracerisk.clock.end);
tracerisk.replay.camera.reset();
document.activeElement.blur();
for (const each of document.querySelectorAll(".timeline-fold[aria-expanded=true]")) each.click();
"""
_AFTER_FRAMES = """
const done = arguments[0];
let left = 4;
const look = () => (left-- ? requestAnimationFrame(look) : done(tracerisk.clock.time));
look();
"""


@pytest.fixture(scope="session")
def open_page(chromium: Any) -> Callable[[Path], Any]:
    """Opens a page from a file, and returns the browser once the replay is drawn."""

    def open_file(path: Path) -> Any:
        chromium.get("about:blank")
        chromium.get_log("browser")
        chromium.get(path.as_uri())
        assert chromium.execute_async_script(_READY) == "ready"
        return chromium

    return open_file


@dataclass(frozen=True)
class ShownRun:
    """A recorded run, its trace and replay, and the page that shows them."""

    trace: Trace
    components: Mapping[str, tuple[str, ...]]
    run: RecordedRun
    replay: Replay
    page: Path


@pytest.fixture(scope="session")
def page_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Section, str], Path]:
    """Writes a page of one section to a file of a name."""
    folder = tmp_path_factory.mktemp("pages")

    def write(section: Section, name: str) -> Path:
        path = folder / name
        text = page_text("A run", Markup("<h1>A run</h1>"), [section])
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture(scope="session")
def shown_run(
    tmp_path_factory: pytest.TempPathFactory,
    pick_and_place: bytes,
    example_in: Any,
    page_of: Callable[[Section, str], Path],
) -> ShownRun:
    """The sample with two of its ten tubes, recorded once."""
    example = example_in(tmp_path_factory.mktemp("rounds"))
    example.write("pick.py", pick_and_place.replace(b"TUBES = 10", b"TUBES = 2"))
    outcome = example.run("trace", "pick.py", "--keep", "kept", "-o", "trace.json", "--quiet")
    assert outcome.code == 0, outcome.err
    trace = trace_json.loads(example.read("trace.json").decode(), "trace.json")
    run = recorded_run(example.folder / "kept")
    assert run is not None
    bound = bind(hardware_of(trace.robot), trace.elements)
    components = {each.component.name: each.elements for each in bound}
    replay = make_replay(run, trace.end.simulated_s)
    section = timeline_section(trace, components, replay=replay)
    return ShownRun(trace, components, run, replay, page_of(section, "run.html"))


@dataclass(frozen=True)
class Opened:
    """What a page did before anybody touched it."""

    n_requests: int
    complaints: list[Any]
    time_after_frames: float


@pytest.fixture(scope="session")
def as_opened(shown_run: ShownRun, open_page: Callable[[Path], Any]) -> Opened:
    page = open_page(shown_run.page)
    return Opened(
        page.execute_script("return performance.getEntriesByType('resource').length"),
        [each for each in page.get_log("browser") if each["level"] != "INFO"],
        page.execute_async_script(_AFTER_FRAMES),
    )


@pytest.fixture
def page(shown_run, as_opened, open_page, chromium):
    """The page of the run as it is when it was opened."""
    if chromium.current_url != shown_run.page.as_uri():
        return open_page(shown_run.page)
    chromium.execute_script(_RESET)
    return chromium


def pixels(page):
    """The picture, (height, width, 3), from below."""
    height, width, text = page.execute_script(_PIXELS)
    values = np.frombuffer(base64.b64decode(text), np.uint8).reshape(height, width, 4)
    return values[:, :, :3].astype(int)


def go_to(page, time):
    assert page.execute_async_script(_GO_TO, time)


def unfold_all(page):
    while closed := page.find_elements("css selector", ".timeline-fold[aria-expanded=false]"):
        page.execute_script("arguments[0].click()", closed[0])


def keys(page, *pressed):
    from selenium.webdriver import ActionChains

    ActionChains(page).send_keys(*pressed).perform()


# The page as it is when it was opened


def test_a_page_opens_from_a_file_with_no_request_and_no_complaint(as_opened):
    assert as_opened.n_requests == 0
    assert as_opened.complaints == []


def test_nothing_plays_by_itself(as_opened):
    assert as_opened.time_after_frames == 0


# The replay


def test_bodies_are_where_the_physics_engine_has_them(page, shown_run):
    import mujoco

    from tracerisk.twin.physics.builder import compile_model

    compiled = compile_model(shown_run.run.robot, shown_run.run.scene)
    data = mujoco.MjData(compiled)
    names = [compiled.body(i).name for i in range(1, compiled.nbody)]
    for time in TIMES:
        data.qpos[:] = shown_run.run.samples.poses[round(time / 0.04)]
        mujoco.mj_kinematics(compiled, data)
        page.execute_script("tracerisk.clock.set(arguments[0], 'test')", time)
        found = page.execute_script("return arguments[0].map(tracerisk.replay.bodyPosition)", names)
        assert np.abs(np.array(found) - data.xpos[1:]).max() < 1e-3


@pytest.mark.parametrize("step", [4, pytest.param(1, marks=pytest.mark.slow)])
def test_the_kinematics_of_shipped_robots_are_those_of_the_physics_engine(page, step):
    import mujoco

    from tracerisk.twin.physics.builder import compile_model

    generator = np.random.default_rng(7)
    for name in robot_names()[::step]:
        robot, scene = load_robot(name), load_scene("pedestal")
        compiled = compile_model(robot, scene)
        data = mujoco.MjData(compiled)
        values = np.zeros(len(robot.joints) + 7 * len(scene.objects))
        for index, joint in enumerate(robot.joints):
            low, high = max(joint.lower, -math.pi), min(joint.upper, math.pi)
            values[index] = generator.uniform(low, high)
            data.qpos[compiled.joint(joint.name).qposadr[0]] = values[index]
        mujoco.mj_kinematics(compiled, data)
        bodies = scene_bodies(robot, scene)
        found = page.execute_script(
            "return tracerisk.replay.poses(arguments[0], arguments[1])",
            bodies_data(bodies),
            values.tolist(),
        )
        for body, pose in zip(bodies, found, strict=True):
            here = data.body(body.name)
            assert pose["xyz"] == pytest.approx(here.xpos, abs=1e-5), f"{name}: {body.name}"
            # A quaternion and its negative are the same turn.
            assert abs(np.dot(pose["quat"], here.xquat)) == pytest.approx(1.0, abs=1e-6)


def test_moving_the_slider_changes_the_picture(page):
    go_to(page, 1.0)
    before = pixels(page)
    slider = page.find_element("id", "timeline-slider")
    for _ in range(3):
        slider.send_keys("\ue00e")  # Page Up: a tenth more
    page.execute_async_script(_AFTER_FRAMES)
    assert page.execute_script("return tracerisk.clock.time") > 8.0
    changed = np.abs(pixels(page) - before).max(axis=2) > 20
    assert np.count_nonzero(changed) > 300


def test_a_dark_page_is_printed_with_a_light_picture(page):
    dark = "document.documentElement.dataset.theme = 'dark'"
    page.execute_script(f"{dark}; document.dispatchEvent(new CustomEvent('tracerisk:theme'))")
    page.execute_async_script(_AFTER_FRAMES)
    assert np.median(pixels(page)) < 80
    page.execute_script("dispatchEvent(new Event('beforeprint'))")
    assert np.median(pixels(page)) > 180
    page.execute_script("dispatchEvent(new Event('afterprint'))")
    assert page.execute_script("return document.documentElement.dataset.theme") == "dark"
    page.execute_script("document.querySelector('[data-theme-choice=auto]')?.click()")


def test_a_link_is_drawn_where_it_is(page):
    """From the side of the camera, the middle of the picture is the link, and not the ground."""
    page.execute_script(
        "const { camera, bodyPosition } = tracerisk.replay; tracerisk.clock.set(3.32, 'test');"
        "camera.target = bodyPosition('panda_link5'); camera.distance = 1.2; camera.pitch = 0;"
    )
    go_to(page, 3.28)
    go_to(page, 3.32)
    seen = pixels(page)
    height, width, _ = seen.shape
    middle = seen[height // 2 - 2 : height // 2 + 2, width // 2 - 2 : width // 2 + 2].mean((0, 1))
    edge = seen[height // 2, :4].mean(0)
    assert np.abs(middle - edge).max() > 15


def test_a_drive_is_coloured_by_its_state(page, shown_run):
    activity = shown_run.replay.activity["panda_joint4"]
    for state in ("moving", "holding"):
        step = int(np.flatnonzero(getattr(activity, state))[200])
        go_to(page, step * 0.002)
        assert page.execute_script("return tracerisk.replay.stateOf('panda_joint4')") == state
    idle = int(np.flatnonzero(~shown_run.replay.activity["panda_hand"].active)[10])
    go_to(page, idle * 0.002)
    assert page.execute_script("return tracerisk.replay.stateOf('panda_hand')") is None


def test_what_is_active_is_reported_in_words(page, shown_run):
    activity = shown_run.replay.activity["panda_hand"]
    step = int(np.flatnonzero(activity.grasping & ~activity.moving)[100])
    go_to(page, step * 0.002)
    reported = page.execute_async_script(
        "const done = arguments[0];"
        "setTimeout(() => done(document.querySelector('[data-now=active]').textContent), 300)"
    )
    assert re.search(r"gripper, (holding, )?grasping: panda_hand", reported)
    assert "always in use: power_system" in reported


def test_keys_turn_the_view_and_move_the_time(page, shown_run):
    camera = "return tracerisk.replay.camera"
    canvas = page.find_element("id", "replay-canvas")
    yaw, distance = (page.execute_script(f"{camera}.{name}") for name in ("yaw", "distance"))
    canvas.send_keys("\ue012", "+")  # left
    assert page.execute_script(f"{camera}.yaw") != yaw
    assert page.execute_script(f"{camera}.distance") < distance
    canvas.send_keys("0")
    assert page.execute_script(f"{camera}.yaw") == yaw
    canvas.send_keys("\ue00f")  # Page Down
    now = page.execute_script("return tracerisk.clock.time")
    assert now == pytest.approx(shown_run.trace.visits[1].start_s, abs=1e-6)
    canvas.send_keys(" ")
    assert page.execute_script("return tracerisk.player.isPlaying")
    canvas.send_keys(" ")
    assert not page.execute_script("return tracerisk.player.isPlaying")


@pytest.mark.slow
def test_dragging_turns_the_view_and_a_click_chooses_a_component(page):
    from selenium.webdriver import ActionChains

    canvas = page.find_element("id", "replay-canvas")
    yaw = page.execute_script("return tracerisk.replay.camera.yaw")
    ActionChains(page).drag_and_drop_by_offset(canvas, 80, 0).perform()
    assert page.execute_script("return tracerisk.replay.camera.yaw") < yaw - 0.1
    assert page.execute_script("return tracerisk.selected.component") is None
    page.execute_script(
        "const { camera, bodyPosition } = tracerisk.replay;"
        "camera.target = bodyPosition('panda_link5'); camera.pitch = 0;"
    )
    ActionChains(page).click(canvas).perform()
    assert page.execute_script("return tracerisk.selected.component") == "electric_motor"


def test_a_mark_is_where_two_bodies_are_nearest(page):
    """A ball of 0.1 m beside a box, a capsule above it: by hand."""
    point = page.execute_script(
        "const at = (x, y, z) => ({ xyz: [x, y, z], quat: [1, 0, 0, 0] });"
        "const box = { shapes: [{ kind: 'box', size: [0.5, 0.5, 0.5] }] };"
        "const ball = { shapes: [{ kind: 'sphere', size: [0.1] }] };"
        "const capsule = { shapes: [{ kind: 'capsule', size: [0.1, 0.2] }] };"
        "const { touchPoint } = tracerisk.replay;"
        "return [touchPoint(ball, at(0.7, 0.2, 0), box, at(0, 0, 0)),"
        " touchPoint(capsule, at(0.1, 0.1, 0.9), box, at(0, 0, 0))];"
    )
    assert point[0] == pytest.approx([0.55, 0.2, 0.0], abs=1e-5)
    assert point[1] == pytest.approx([0.1, 0.1, 0.55], abs=1e-4)


@pytest.mark.slow
def test_a_lost_picture_comes_back(page):
    go_to(page, 2.0)
    found = page.execute_async_script(
        "const done = arguments[0];"
        "const canvas = document.getElementById('replay-canvas');"
        "const lose = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');"
        "const message = document.querySelector('.replay-message');"
        "const seen = [];"
        "canvas.addEventListener('webglcontextlost', () => setTimeout(() => {"
        "  seen.push(message.hidden); lose.restoreContext(); }, 50));"
        "canvas.addEventListener('webglcontextrestored', () => setTimeout(() => {"
        "  seen.push(message.hidden); done(seen); }, 500));"
        "lose.loseContext();"
    )
    assert found == [False, True]
    assert np.ptp(pixels(page)) > 50


# The risk on the arm, and what the picture holds

_SHARES = [
    ["pick", "electric_motor", "panda_joint2", 0.4],
    ["place", "electric_motor", "panda_joint2", 0.2],
    ["place", "electric_motor", "panda_joint4", 0.1],
    ["pick", "gripper", None, 0.25],
    ["pick", "power_system", None, 0.05],
]


@pytest.fixture(scope="session")
def risky(shown_run: ShownRun, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of the run beside a headline that knows which element has which share."""
    data = Data.of_json(RISK, {"shares": _SHARES, "blocks": {"pick": ["#run", "pick.py:3"]}})
    lead = (
        f'<h1 id="run">A run</h1><script type="{data.kind}" id="{data.name}">{data.text}</script>'
    )
    section = timeline_section(shown_run.trace, shown_run.components, replay=shown_run.replay)
    path = tmp_path_factory.mktemp("risk") / "risk.html"
    path.write_text(page_text("A run", Markup(lead), [section]), encoding="utf-8")
    return path


def risk_of(page, element):
    return page.execute_script("return tracerisk.replay.riskOf(arguments[0])", element)


def test_the_arm_shows_the_whole_mission_and_then_fills_up_with_the_time(risky, open_page):
    page = open_page(risky)
    legend = "return document.querySelector('.replay-legend').textContent"
    assert risk_of(page, "panda_joint2") == pytest.approx(0.6)
    # A component without a figure for each element: its only element has all of it.
    assert risk_of(page, "panda_hand") == pytest.approx(0.25)
    assert risk_of(page, "panda_joint1") == 0
    told = page.execute_script(legend)
    assert "60\xa0%" in told
    assert "whole mission" in told
    assert "Not on the arm: power_system 5\xa0%" in told
    seen = []
    for time in (1e-3, *TIMES[1:], 1e6):
        page.execute_script("tracerisk.clock.set(arguments[0], 'test')", time)
        seen.append(risk_of(page, "panda_joint2"))
    assert seen[0] < 0.01
    assert seen == sorted(seen)
    assert seen[1] < seen[-1] == pytest.approx(0.6)
    assert "100\xa0% of it by" in page.execute_script(legend)
    # At times at which a contact is marked too.
    page.execute_async_script(_AFTER_FRAMES)
    go_to(page, 7.88)
    assert page.execute_script("return tracerisk.replay.riskOf('panda_joint2')") > 0
    assert [each for each in page.get_log("browser") if each["level"] != "INFO"] == []


def test_risk_and_activity_are_two_colourings_of_one_arm(risky, open_page):
    page = open_page(risky)
    go_to(page, 3.32)
    risk = pixels(page)
    page.find_element("css selector", '[data-colours="activity"]').click()
    page.execute_async_script(_AFTER_FRAMES)
    assert page.execute_script("return tracerisk.replay.colours") == "activity"
    assert np.count_nonzero(np.abs(pixels(page) - risk).max(axis=2) > 20) > 200
    pressed = page.execute_script(
        "return [...document.querySelectorAll('[data-colours]')].map(e => e.ariaPressed)"
    )
    assert pressed == ["false", "true"]
    assert "moving" in page.execute_script(
        "return document.querySelector('.replay-legend').textContent"
    )


@pytest.mark.slow
def test_a_click_on_a_link_leads_to_its_share_and_to_the_source(risky, open_page):
    from selenium.webdriver import ActionChains

    page = open_page(risky)
    page.execute_script(
        "const { camera, bodyPosition } = tracerisk.replay;"
        "camera.target = bodyPosition('panda_link2'); camera.distance = 1; camera.pitch = 0;"
        "camera.isHome = false; tracerisk.replay.ask();"
    )
    page.execute_async_script(_AFTER_FRAMES)
    ActionChains(page).click(page.find_element("id", "replay-canvas")).perform()
    assert page.execute_script("return tracerisk.selected.component") == "electric_motor"
    chosen = page.find_element("css selector", ".replay-chosen")
    assert "electric_motor: 70 % of the mission" in chosen.text
    assert "of which panda_joint2 60 %" in chosen.text
    (link,) = chosen.find_elements("tag name", "a")
    assert link.get_attribute("href").endswith("#run")
    assert (link.text, link.get_attribute("title")) == ("pick 40 %", "pick.py:3")


@pytest.mark.slow
@pytest.mark.parametrize("size", [(1400, 1000), (400, 900)])
def test_the_picture_holds_all_that_the_arm_reaches_and_little_more(page, shown_run, size):
    metrics = {"width": size[0], "height": size[1], "deviceScaleFactor": 0.25, "mobile": False}
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    page.execute_script("tracerisk.replay.camera.reset(); tracerisk.replay.ask();")
    page.execute_async_script(_AFTER_FRAMES)
    names = [body.name for body in shown_run.replay.bodies if body.kind in ("robot", "object")]
    # In one go: each time at which the page comes to itself is drawn.
    places = page.execute_script(
        "return arguments[0].flatMap((time) => { tracerisk.clock.set(time, 'test');"
        " return arguments[1].map(tracerisk.replay.bodyPosition); })",
        np.linspace(0, shown_run.trace.end.simulated_s, 40).tolist(),
        names,
    )
    matrix = page.execute_script(
        "const { camera } = tracerisk.replay; return camera.matrix(camera.aspect, camera.covered)"
    )
    page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    clip = np.column_stack((np.array(places), np.ones(len(places)))) @ np.array(matrix).reshape(
        4, 4
    )
    seen = clip[:, :2] / clip[:, 3:]
    assert np.abs(seen).max() < 1
    # The racks beside the tubes take some of the rest.
    assert np.ptp(seen, axis=0).max() > 0.95


@pytest.mark.slow
def test_several_arms_play_on_one_page(page):
    """Each has a stage and a camera of its own, and follows the one clock."""
    drawn = page.execute_async_script(
        "const done = arguments[0];"
        "const stage = document.querySelector('.replay-stage').cloneNode(true);"
        "stage.querySelectorAll('[id]').forEach((each) => each.removeAttribute('id'));"
        "document.querySelector('.beside').append(stage);"
        "const { bodies, frames } = tracerisk.data('replay-bodies');"
        "const packed = tracerisk.bytes('replay-frames');"
        "tracerisk.replay.create(stage, { bodies, frames, packed }).then((other) => {"
        "  other.camera.orbit(0.5, 0);"
        "  tracerisk.clock.set(7.88, 'test');"
        "  const { camera, bodyPosition } = tracerisk.replay;"
        "  requestAnimationFrame(() => requestAnimationFrame(() => { stage.remove(); done(["
        "    other.drawn, other.camera.yaw !== camera.yaw,"
        "    other.bodyPosition('panda_hand'), bodyPosition('panda_hand')]); }));"
        "});"
    )
    assert drawn[0] > 0
    assert drawn[1]
    assert drawn[2] == drawn[3]


# The timeline


def test_the_chart_has_what_the_trace_has(page, shown_run):
    found = page.execute_script(_CHART)
    assert found["visits"] == len(shown_run.trace.visits) == N_VISITS
    assert found["lanes"] == [each.ref.name for each in shown_run.trace.functions]
    assert set(shown_run.components) <= set(found["lines"])
    unfold_all(page)
    many = {name for own in shown_run.components.values() if len(own) > 1 for name in own}
    assert set(found["lines"]) | many <= set(page.execute_script(_CHART)["lines"])


def test_as_many_segments_are_drawn_as_there_are(page):
    unfold_all(page)
    lines = page.execute_script(_CHART)["lines"]
    rows = page.execute_script("return tracerisk.data('timeline-data').rows")
    for row in rows:
        assert lines[row["component"]] == row["segments"][2::3]
        for element in row["elements"] if len(row["elements"]) > 1 else ():
            assert lines[element["name"]] == element["segments"][2::3]


def test_segments_of_an_element_sum_to_its_exposure(page, shown_run):
    """What the page has of each element, against what the trace says it did in the run."""
    rows = page.execute_script("return tracerisk.data('timeline-data').rows")
    segments = {each["name"]: each["segments"] for row in rows for each in row["elements"]}
    assert set(shown_run.replay.activity) <= set(segments)
    for name in shown_run.replay.activity:
        exposure = shown_run.trace.active[name]
        triples = np.array(segments[name]).reshape(-1, 3)
        states = triples[:, 2].astype(int)
        for bit, seconds in (
            (MOVING, exposure.moving_s),
            (HOLDING, exposure.holding_s),
            (GRASPING, exposure.grasping_s),
        ):
            reported = triples[(states & bit) > 0, 1].sum() / 1000
            assert reported == pytest.approx(seconds, abs=1e-6), f"{name}, {bit}"
        assert triples[:, 1].sum() / 1000 == pytest.approx(exposure.active_s, abs=1e-6)


def test_playing_moves_the_time_and_pausing_stops_it(page):
    play = page.find_element("css selector", '[data-time="play"]')
    assert page.execute_script("return tracerisk.clock.time") == 0
    play.click()
    assert play.get_attribute("aria-label") == "Pause"
    reached = page.execute_async_script(
        "const done = arguments[0];"
        "tracerisk.clock.subscribe((time) => { if (time > 0.4) done(time); });"
    )
    assert 0.4 < reached < 3.0
    play.click()
    stopped = page.execute_script("return tracerisk.clock.time")
    assert page.execute_async_script(_AFTER_FRAMES) == stopped


def test_buttons_step_from_visit_to_visit(page, shown_run):
    for visit in shown_run.trace.visits[1:4]:
        page.find_element("css selector", '[data-time="next"]').click()
        now = page.execute_script("return tracerisk.clock.time")
        assert now == pytest.approx(visit.start_s, abs=1e-6)
    page.find_element("css selector", '[data-time="previous"]').click()
    now = page.execute_script("return tracerisk.clock.time")
    assert now == pytest.approx(shown_run.trace.visits[2].start_s, abs=1e-6)
    reported = page.find_element("id", "timeline-slider").get_attribute("aria-valuetext")
    assert reported == f"{now:.2f} s, pick, visit 3 of {N_VISITS}"


def test_arrow_keys_go_along_the_visits_and_say_each(page, shown_run):
    page.execute_script("document.querySelector('.timeline-visit[tabindex=\"0\"]').focus()")
    keys(page, "\ue014", "\ue014")  # right
    tip = page.find_element("css selector", ".timeline-tip")
    assert tip.is_displayed()
    assert tip.text.startswith("pick, visit 3: ")
    keys(page, "\ue007")  # Enter
    now = page.execute_script("return tracerisk.clock.time")
    assert now == pytest.approx(shown_run.trace.visits[2].start_s, abs=1e-6)
    assert page.execute_script("return tracerisk.selected.function") == "pick"
    assert len(page.find_elements("css selector", ".timeline-visit.is-chosen")) == 2


def test_zooming_to_a_visit_shows_it_alone(page, shown_run):
    visit = shown_run.trace.visits[2]
    page.execute_script("tracerisk.clock.set(arguments[0], 'test')", visit.start_s + 0.1)
    page.find_element("css selector", '[data-time="visit"]').click()
    view = page.execute_script("return tracerisk.timeline.view")
    assert view["from"] < visit.start_s < visit.start_s + visit.duration_s < view["to"]
    assert view["to"] - view["from"] < 1.3 * visit.duration_s
    assert page.execute_script(_CHART)["visits"] <= 3
    page.find_element("css selector", '[data-time="whole"]').click()
    assert page.execute_script(_CHART)["visits"] == N_VISITS


def test_a_pointer_on_a_row_is_reported_what_is_there(page):
    from selenium.webdriver import ActionChains
    from selenium.webdriver.support.ui import WebDriverWait

    line = page.find_element("css selector", '[data-line="gripper"]')
    segment = line.find_element("css selector", ".timeline-segment")

    def reported(driver):
        # A busy machine hands the pointer on later than the driver returns.
        ActionChains(driver).move_to_element(segment).perform()
        return driver.find_element("css selector", ".timeline-tip").text

    tip = WebDriverWait(page, 20).until(reported)
    assert re.fullmatch(r"gripper: (moving|holding|grasping|, )+, [\d.]+ s to [\d.]+ s", tip)


def test_what_is_spoken_waits_until_the_slider_rests(page):
    changes, spoken = page.execute_async_script(
        "const done = arguments[0];"
        "const live = document.getElementById('timeline-live');"
        "let changes = 0;"
        "new MutationObserver(() => changes++).observe(live, { childList: true });"
        "for (let i = 1; i <= 200; i++) tracerisk.clock.set(i / 20, 'slider');"
        "setTimeout(() => done([changes, live.textContent]), 1100);"
    )
    assert changes == 1
    assert re.match(rf"10\.00 s, \w+, visit \d+ of {N_VISITS}: .*electric_motor: ", spoken)


def test_every_visit_is_in_the_table(page, shown_run):
    rows = page.execute_script(
        "return [...document.querySelectorAll('#visits-table tbody tr')]"
        ".map((row) => [...row.cells].slice(0, 5).map((cell) => cell.textContent.trim()))"
    )
    assert rows == [
        [str(n), v.function.name, f"{v.start_s:.3f}", f"{v.duration_s:.3f}", v.outcome]
        for n, v in enumerate(shown_run.trace.visits, start=1)
    ]


# Other pages, and this one without what it needs


@pytest.mark.slow
def test_a_touch_that_nobody_wants_has_a_mark_with_its_force(open_page, shown_run, page_of):
    first, *rest = shown_run.trace.visits
    touch = Contact("panda_link5", "table", 0.5, 1.0, 42.0, expected=False)
    trace = replace(shown_run.trace, visits=(replace(first, contacts=(touch,)), *rest))
    section = timeline_section(trace, shown_run.components, replay=shown_run.replay)
    page = open_page(page_of(section, "touch.html"))
    go_to(page, 0.7)
    (label,) = page.find_elements("css selector", ".replay-label.is-fail")
    assert label.text == "panda_link5 \N{EN DASH} table, up to 42.0 N"
    go_to(page, 1.8)
    assert not page.find_elements("css selector", ".replay-label")


def test_without_samples_there_is_a_timeline_of_visits(chromium, shown_run, page_of):
    section = timeline_section(shown_run.trace, shown_run.components)
    chromium.get(page_of(section, "visits.html").as_uri())
    assert not chromium.find_elements("id", "replay-canvas")
    found = chromium.execute_script(_CHART)
    assert found["visits"] == N_VISITS
    assert all(state & SOMEWHEN for state in found["lines"]["electric_motor"])
    assert "there is no replay" in chromium.find_element("css selector", ".aside").text


@pytest.mark.slow
def test_a_mark_leads_to_its_instant(shown_run, page_of, chromium):
    found = tuple(Finding("touch", f"touch {n}", 2.0 + n, None) for n in range(9))
    section = timeline_section(
        replace(shown_run.trace, findings=found),
        shown_run.components,
        faults=(Fault("panda_joint4", "dead", 5.5),),
    )
    page = chromium
    page.get(page_of(section, "marked.html").as_uri())
    marks = page.find_elements("css selector", ".timeline-mark")
    assert len(marks) == 10
    page.find_element("css selector", ".timeline-mark.is-fault path").click()
    assert page.execute_script("return tracerisk.clock.time") == 5.5
    page.find_element("css selector", "[data-time-at='3.0']").click()
    assert page.execute_script("return tracerisk.clock.time") == 3.0
    names = page.find_elements("css selector", ".timeline-name.is-marks")
    assert [each.text for each in names] == ["faults, findings"]
    folded = page.find_elements("css selector", "details .timeline-mark-jump")
    assert len(folded) == 4
    axe = pytest.importorskip("selenium_axe_python", reason="selenium-axe-python is missing").Axe
    checker = axe(page)
    checker.inject()
    found = [each for each in checker.run()["violations"] if each["impact"] in _SERIOUS]
    assert not found, axe.report(found)


@pytest.mark.slow
def test_of_very_many_visits_those_that_can_be_seen_are_drawn_and_each_can_be_reached(
    chromium, shown_run, page_of
):
    first = shown_run.trace.visits[0]
    many = tuple(replace(first, start_s=i * 1e-3, duration_s=1e-3) for i in range(6_000))
    end = replace(shown_run.trace.end, simulated_s=6.0)
    trace = replace(shown_run.trace, visits=many, end=end)
    path = page_of(timeline_section(trace, shown_run.components), "many.html")
    chromium.get(path.as_uri())
    drawn = chromium.execute_script(_CHART)["visits"]
    assert 500 < drawn < 3000
    chart = chromium.find_element("css selector", ".timeline-visit[tabindex='0']")
    chromium.execute_script("arguments[0].focus()", chart)
    keys(chromium, *["\ue014"] * 3)  # right
    focused = "return document.activeElement.dataset.stretch"
    assert chromium.execute_script(focused) == "3"


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        ("HTMLCanvasElement.prototype.getContext = () => null;", "WebGL 2 is missing"),
        pytest.param(
            "delete window.DecompressionStream;", "too old for the replay", marks=pytest.mark.slow
        ),
        ("window.DecompressionStream = class { constructor() { throw Error('no'); } };", "no. The"),
    ],
)
def test_without_webgl_or_the_frames_a_sentence_says_so_and_the_timeline_works(
    chromium, shown_run, broken, said
):
    begun = chromium.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": broken})
    try:
        chromium.get("about:blank")
        chromium.get(shown_run.page.as_uri())
        script = "const done = arguments[0]; tracerisk.replay.ready.then(done, () => done());"
        chromium.execute_async_script(script)
        message = chromium.find_element("css selector", ".replay-message")
        assert message.is_displayed()
        assert said in message.text
        assert chromium.execute_script(_CHART)["visits"] == N_VISITS
    finally:
        chromium.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", begun)
        chromium.get("about:blank")
