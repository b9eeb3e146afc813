"""Choose the launch file whose parameters, arguments and remaps a controller is run with."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from tracerisk.common.limits import Limits
from tracerisk.config import Settings
from tracerisk.errors import InputError, Location, one_of
from tracerisk.pipeline.launch.candidate import Candidate
from tracerisk.pipeline.launch.find import LaunchFile, find_launch_files, ros_of
from tracerisk.pipeline.launch.parameter_files import (
    NO_PARAMETERS_GIVEN,
    GivenParameters,
    given_parameters,
    setup_of_parameter_file,
)
from tracerisk.pipeline.launch.parameter_reads import Asked, asked_by
from tracerisk.pipeline.launch.program import Program, program_of, shown
from tracerisk.pipeline.launch.readme_arguments import ReadmeArguments
from tracerisk.pipeline.launch_files.parameter_text import ParameterTextError, read_text
from tracerisk.pipeline.launch_files.process import read_launch
from tracerisk.pipeline.launch_files.records import (
    LaunchReading,
    LaunchSetup,
    RobotSource,
    words_of_missing,
)
from tracerisk.pipeline.launch_files.roslaunch_xml import read_roslaunch
from tracerisk.pipeline.workspace.controller import Controller
from tracerisk.pipeline.workspace.workspace import Workspace, workspace_of

_MOST_READ = {1: 40, 2: 10}  # launch files of ROS 2 cost a process each
_MOST_INCLUDERS = {1: 40, 2: 4}
_AT_ONCE = 2
_MOST_LISTED = 3
# The run itself relies on environment variables whose names begin so.
_NOT_SET = ("HOME", "LD_", "MUJOCO", "PATH", "PYTHON", "TMP", "TZ")


@dataclass(frozen=True, slots=True)
class LaunchChoice:
    """What a controller is given by a launch or parameter file."""

    setup: LaunchSetup | None = None
    """The parameters, arguments and remaps; `None` where nothing is given."""
    notes: tuple[str, ...] = ()
    """Sentences on what is given and from where, or why nothing is."""
    robots: tuple[RobotSource, ...] = ()
    """The robot description files that the launch file names."""
    file: str = ""
    """The launch file that starts the controller, for messages; empty for none."""
    given: GivenParameters = NO_PARAMETERS_GIVEN
    """What the parameter files give that the controller's own arguments name."""


NOTHING_CHOSEN = LaunchChoice()
"""Nothing of a launch file."""


def choose_launch(controller: Controller, settings: Settings) -> LaunchChoice:
    """Return what a controller is given by the launch file that starts it.

    It is the file of the settings, else the one of the workspace that goes best with the parameter
    files among the controller's own arguments, and of these the one whose node is given most of
    the parameters that the source asks for, and of equal ones the one sorted first; else a
    parameter file of the package that names the controller's node.
    Raises InputError where the file of the settings cannot be read or does not start it, and
    LimitError where reading a file takes too long or too much memory: then nothing is chosen.
    """
    if settings.launch is False:
        return LaunchChoice()
    workspace = workspace_of(controller, settings)
    asked = asked_by(controller, workspace.python_packages)
    given = given_parameters(settings.args, asked.nodes)
    return replace(_chosen(controller, settings, workspace, asked, given), given=given)


def _chosen(
    controller: Controller,
    settings: Settings,
    workspace: Workspace,
    asked: Asked,
    given: GivenParameters,
) -> LaunchChoice:
    root = controller.root.resolve()
    script = controller.path.resolve()
    program = program_of(script, root, workspace)
    ros = controller.ros_version
    readmes = ReadmeArguments(controller.project, workspace)
    search = _Search(program, workspace, asked, given, root, settings.limits, readmes)
    problems = search.problems
    if isinstance(settings.launch, str):
        return search.named(Path(settings.launch), ros)
    files = find_launch_files(program, root, workspace, ros)
    direct = [file for file in files if file.is_direct][: _MOST_READ[ros]]
    candidates = search.candidates(direct)
    best = search.best(candidates)
    if direct and (best is None or best.gives(asked.required) < len(asked.required)):
        around = [file for file in files if not file.is_direct][: _MOST_INCLUDERS[ros]]
        candidates += search.candidates(around)
        best = search.best(candidates)
    robots: tuple[RobotSource, ...] = ()
    by = ""
    if best is not None:
        robots, by = best.reading.robots, shown([best.file.path], root)[0]
        launch_setup = _setup(best, candidates, asked, root)
        if launch_setup is not None:
            return LaunchChoice(launch_setup, launch_setup.notes, robots, by)
    if ros == 2 and (setup := setup_of_parameter_file(program, workspace, asked, root)) is not None:
        return LaunchChoice(setup, setup.notes, robots, by)
    if best is None and direct:
        shown_files = ", ".join(shown([file.path for file in direct], root)[:_MOST_LISTED])
        reason = f": {problems[0]}" if problems else " with the defaults of its arguments"
        return LaunchChoice(notes=(f"launch: {shown_files} does not start it{reason}",))
    return LaunchChoice(robots=robots, file=by)


@dataclass(frozen=True, slots=True)
class _Search:
    """A search for what a program is given."""

    program: Program
    """The controller as launch files call it."""
    workspace: Workspace
    """The workspace with its packages."""
    asked: Asked
    """The parameters that the controller's source asks for."""
    given: GivenParameters
    """The parameters that the controller's own arguments give."""
    root: Path
    """The root of the controller, from which messages name files."""
    limits: Limits
    """The limits on time and memory of reading a file."""
    readmes: ReadmeArguments
    """The arguments that READMEs give to launch files."""
    problems: list[str] = field(default_factory=list)
    """Why files gave nothing, filled by the search."""

    def named(self, path: Path, wanted_ros: Literal[1, 2]) -> LaunchChoice:
        """Return what the launch file gives that the user has named."""
        place = Location(str(path))
        try:
            ros = ros_of(path, read_text(path))
        except ParameterTextError as error:
            raise InputError(f"the launch file {error}", place) from error
        if ros is None:
            raise InputError(
                "is not a launch file; allowed: one of XML, YAML or Python, of ROS 1 or ROS 2",
                place,
            )
        if ros != wanted_ros:
            raise InputError(
                f"is a launch file of ROS {ros}, but the controller is of ROS {wanted_ros}; name "
                f"one of ROS {wanted_ros}, or none with --no-launch",
                place,
            )
        file = LaunchFile(path.resolve(), ros, True)
        candidates = self.candidates([file])
        if not candidates:
            (reading,) = read_launch_files([file], self.workspace, self.limits)
            started = sorted({f"{node.package}/{node.executable}" for node in reading.nodes})
            wanted = f"{self.program.package}/{self.program.script.name}"
            why = f" ({self.problems[0]})" if self.problems else ""
            raise InputError(
                f"does not start {wanted}{why}; it starts: {one_of(started).partition(': ')[2]}",
                place,
            )
        setup = _setup(candidates[0], candidates, self.asked, self.root)
        robots = candidates[0].reading.robots
        return LaunchChoice(
            setup, () if setup is None else setup.notes, robots, shown([path], self.root)[0]
        )

    def candidates(self, files: Sequence[LaunchFile]) -> list[Candidate]:
        """Return of each file the node that is the program; what cannot be read is noted."""
        result = []
        files = [self.readmes.given(file) for file in files]
        readings = read_launch_files(files, self.workspace, self.limits)
        for file, reading in zip(files, readings, strict=True):
            nodes = [
                node
                for started_node in reading.nodes
                if (node := self.program.started_as(started_node)) is not None
            ]
            made = [
                Candidate(
                    file,
                    reading,
                    node,
                    len(nodes),
                    self.asked.nodes if node.name is None else (node.name,),
                )
                for node in nodes
            ]
            best = self.best(made)
            if best is not None:
                result.append(best)
            else:
                self.problems.extend(reading.problems)
        return result

    def best(self, candidates: Sequence[Candidate]) -> Candidate | None:
        """Return the candidate that fits the given parameters best.

        Among equal ones it is the one that gives most of the parameters asked for, then the first.
        """
        return max(
            candidates,
            key=lambda candidate: (
                candidate.fits(self.given),
                candidate.gives(self.asked.required),
                candidate.gives(self.asked.names),
                candidate.gives(self.asked.literals),
                not candidate.file.is_test,
            ),
            default=None,
        )


def read_launch_files(
    files: Sequence[LaunchFile], workspace: Workspace, limits: Limits
) -> list[LaunchReading]:
    """Return what each of some launch files of either ROS starts.

    Raises LimitError where reading one takes too long or too much memory.
    """
    if not files:
        return []
    from concurrent.futures import ThreadPoolExecutor

    packages = workspace.findable

    def read(file: LaunchFile) -> LaunchReading:
        if file.ros == 2:
            return read_launch(file.path, workspace, limits, file.arguments)
        return read_roslaunch(file.path, packages, file.arguments)

    with ThreadPoolExecutor(_AT_ONCE) as pool:
        return list(pool.map(read, files))


def _setup(
    best: Candidate, candidates: Sequence[Candidate], asked: Asked, root: Path
) -> LaunchSetup | None:
    """Return what a candidate gives, None where that is nothing but a name."""
    node = best.node
    parameters = best.parameters
    given = (parameters, node.arguments, node.ros_arguments, node.remaps, node.namespace)
    if not any((*given, node.environment, _left_out(best, asked), best.reading.missing)):
        return None
    file = shown([best.file.path], root)[0]
    readme = [best.file.said_in.rpartition(":")[0]] if best.file.said_in else []
    setup = LaunchSetup(
        file=file,
        kind="launch",
        ros=best.file.ros,
        name=node.name,
        namespace=node.namespace,
        arguments=node.arguments,
        ros_arguments=node.ros_arguments,
        parameters=parameters,
        remaps=node.remaps,
        environment=tuple(pair for pair in node.environment if not pair[0].startswith(_NOT_SET)),
        own=best.private,
        sources=tuple(sorted({*shown([best.file.path, *best.reading.sources], root), *readme})),
        missing=tuple(_missing(best, file, root)),
    )
    return replace(setup, notes=tuple(_notes(setup, best, candidates, asked, root)))


def _missing(best: Candidate, shown_file: str, root: Path) -> Iterator[tuple[str, str]]:
    """Yield the places of a launch file that load what is not there, each with that file."""
    for place, path in best.reading.missing:
        file, _, line = place.partition(":")
        at = f"{shown_file}:{line}" if Path(file).name == best.file.path.name else place
        yield at, shown([path], root)[0]


def _notes(
    setup: LaunchSetup,
    best: Candidate,
    candidates: Sequence[Candidate],
    asked: Asked,
    root: Path,
) -> list[str]:
    counts = (
        (len(best.own) if setup.ros == 2 else len(setup.parameters), "parameter"),
        (len(setup.arguments), "argument"),
        (len(setup.remaps), "remap"),
    )
    given = ", ".join(f"{n} {what}{'s' if n > 1 else ''}" for n, what in counts if n)
    lines = [
        f"launch: parameters, arguments and remaps from {setup.file}"
        f"{f' ({given})' if given else ''}; --no-launch leaves them out"
    ]
    if best.file.given:
        lines.append(f"launch: its arguments are {best.file.given}")
    others = [candidate for candidate in candidates if candidate is not best]
    for is_same, which in ((True, "the same"), (False, "other values")):
        files = [other.file.path for other in others if best.same_as(other, asked) is is_same]
        if files:
            listed = ", ".join(shown(files, root)[:_MOST_LISTED])
            more = f" and {len(files) - _MOST_LISTED} more" if len(files) > _MOST_LISTED else ""
            choose = "" if is_same else "; --launch FILE takes another"
            lines.append(f"launch: {listed}{more} would give {which}{choose}")
    lines += [
        f"launch: {words_of_missing(place, file)}; restore it, or --launch FILE takes another "
        "launch file"
        for place, file in setup.missing
    ]
    if best.started > 1:
        lines.append(f"launch: {setup.file} starts it {best.started} times; one of them is run")
    for name, reason in _left_out(best, asked)[:_MOST_LISTED]:
        what = "some parameters are" if name == "*" else f"parameter {name} is"
        lines.append(f"launch: {what} left out: {reason}")
    return lines


def _left_out(best: Candidate, asked: Asked) -> list[tuple[str, str]]:
    """Return the parameters that were not evaluated and that the source may ask for."""
    words = asked.names | asked.literals
    reasons = dict([*best.node.left_out, *best.reading.left_out])
    return [
        (name, reason)
        for name, reason in reasons.items()
        if name == "*" or name in words or f"~{name.rpartition('/')[2]}" in words
    ]
