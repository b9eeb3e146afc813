"""Options that several verbs share."""

from __future__ import annotations

from tracerisk.cli.shared.values import count, cycles, positive, probability
from tracerisk.errors import InputError

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from typing import Any

    from tracerisk.adder.merge.edits_found import MergePolicy


def add_json(
    parser: argparse.ArgumentParser, *, verbose: str = "print everything, as this verb always does"
) -> None:
    """Add `--json`, `--verbose`, whose help is given, `--quiet` and `--color`.

    Who adds `-v` to one verb adds it to the next: it is refused by none.
    """
    when = ("auto", "always", "never")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    parser.add_argument("-v", "--verbose", action="store_true", help=verbose)
    parser.add_argument(
        "-q", "--quiet", action="store_true", help="print only errors and what was asked for"
    )
    parser.add_argument(
        "--color",
        metavar="WHEN",
        choices=when,
        default="auto",
        help="always, never or auto: on a terminal, as NO_COLOR and FORCE_COLOR say (auto)",
    )


def add_sarif(parser: argparse.ArgumentParser) -> None:
    """Add `--sarif`."""
    parser.add_argument(
        "--sarif", metavar="FILE", help="write what was found as SARIF, for code scanning"
    )


def add_ci_reports(parser: argparse.ArgumentParser) -> None:
    """Add the files that jobs of GitHub and GitLab take."""
    add_sarif(parser)
    parser.add_argument(
        "--code-quality",
        metavar="FILE",
        help="write what was found as JSON, for code quality on GitLab",
    )
    parser.add_argument(
        "--metrics",
        metavar="FILE",
        help="write the figures as OpenMetrics, for metrics reports on GitLab",
    )


def add_record(parser: argparse.ArgumentParser) -> None:
    """Add the recording of the run as a file for other tools."""
    parser.add_argument(
        "--record",
        metavar="OUT.mcap",
        help="write the run as an MCAP file (`tracerisk docs recordings`)",
    )
    parser.add_argument(
        "--record-rate",
        metavar="HZ",
        type=float,
        default=500.0,
        help="how often joint states are written into it, 50 to 500 (500)",
    )


def add_run_options(parser: argparse.ArgumentParser, *, needs_file: bool = True) -> None:
    """Add the controller, which may be left out without `needs_file`, and what its run needs."""
    parser.add_argument(
        "controller",
        metavar="FILE",
        nargs=None if needs_file else "?",
        help="the controller's Python file; with --live also a C++ source or an executable",
    )
    parser.add_argument(
        "argv",
        metavar="ARG",
        nargs="*",
        help="arguments for the controller, after --; of a C++ source the command that starts it",
    )
    group = parser.add_argument_group("the run")
    group.add_argument(
        "--robot",
        metavar="NAME|FILE",
        help="robot to simulate (default: inferred from joint and group names)",
    )
    group.add_argument(
        "--scene", metavar="NAME|FILE", help="scene to simulate (default: that of the robot)"
    )
    group.add_argument(
        "--scenario",
        metavar="FILE",
        help="scenario: messages, services and objects around the controller "
        "(`tracerisk docs scenario`)",
    )
    group.add_argument(
        "--params",
        metavar="FILE",
        action="append",
        default=[],
        help="parameters as YAML, of ROS 1 or ROS 2; repeatable",
    )
    group.add_argument(
        "--driver",
        dest="drivers",
        metavar="FILE",
        action="append",
        default=[],
        help="a description of what the robot's driver serves; repeatable",
    )
    either = group.add_mutually_exclusive_group()
    either.add_argument(
        "--launch",
        metavar="FILE",
        help="launch file that starts the controller (default: searched for)",
    )
    either.add_argument(
        "--no-launch", dest="launch", action="store_const", const=False, help="ignore launch files"
    )
    group.add_argument(
        "--no-companions",
        dest="companions",
        action="store_const",
        const=False,
        help="do not start workspace nodes that the controller depends on",
    )
    group.add_argument(
        "--no-draft",
        dest="draft",
        action="store_const",
        const=False,
        help="do not assume missing inputs; a run that needs one ends without a trace",
    )
    group.add_argument(
        "--duration",
        dest="duration_s",
        metavar="S",
        type=positive,
        help="simulated time after which the run is over (300 s)",
    )
    group.add_argument(
        "--cpu-limit",
        dest="cpu_limit_s",
        metavar="S",
        type=positive,
        help="processor time after which the controller is stopped (120 s)",
    )
    group.add_argument(
        "--wall-limit",
        dest="wall_limit_s",
        metavar="S",
        type=positive,
        help="wall time after which it is stopped (1800 s)",
    )
    group.add_argument(
        "--stall-limit",
        dest="stall_limit_s",
        metavar="S",
        type=positive,
        help="time it computes or sleeps without simulated progress, and that of each process that "
        "reads a launch, xacro or model file (30 s)",
    )
    group.add_argument(
        "--memory-limit",
        dest="memory_limit_mb",
        metavar="MB",
        type=count,
        help="address space of the controller's process (8192 MB)",
    )
    group.add_argument(
        "--mission-cycles",
        metavar="N",
        type=cycles,
        help="cycles per mission assumed for a controller that loops forever (10)",
    )
    add_sandbox(group)
    group.add_argument("--seed", metavar="N", type=count, help="seed of all that is random (0)")
    group.add_argument(
        "--answer",
        dest="answers",
        metavar="TEXT",
        action="append",
        default=[],
        help="an answer for input(), in turn; then Enter",
    )
    group.add_argument("--keep", metavar="DIR", help="keep the recording of the run in a folder")
    group.add_argument("--log", metavar="FILE", help="write the log in the published text format")


def add_sandbox(group: argparse._ActionsContainer) -> None:
    """Add the option for the sandbox of what is run of a workspace."""
    group.add_argument(
        "--sandbox",
        metavar="MODE",
        choices=("auto", "require", "off"),
        help="contain what is run of the workspace: where that works (auto), always and by no "
        "setting widened (require), never (off)",
    )


def add_system(group: argparse._ActionsContainer) -> None:
    """Add the part that is the system."""
    group.add_argument(
        "--system",
        metavar="NAME",
        help="part of a description in SysML v2 that is the system, where there are several",
    )


def add_hardware_options(parser: argparse.ArgumentParser) -> None:
    """Add what turns use into probabilities."""
    from typing import get_args

    from tracerisk.config import ActiveMode

    group = parser.add_argument_group("the hardware")
    group.add_argument(
        "--hardware", metavar="FILE", help="hardware description (default: that of the robot)"
    )
    add_system(group)
    group.add_argument(
        "--active",
        choices=get_args(ActiveMode),
        help="which time counts: moving, or also holding and grasping (moving+holding)",
    )


def add_profile(parser: argparse.ArgumentParser) -> None:
    """Add the operational profile."""
    parser.add_argument(
        "--profile",
        metavar="FUNCTION:TARGET=SHARE,...",
        action="append",
        default=[],
        help="what follows a function, and how often: place:init=0.9,done=0.1; or a file by "
        "`tracerisk field`",
    )


def add_explain(parser: argparse.ArgumentParser) -> None:
    """Add the function whose figures are derived."""
    parser.add_argument(
        "--explain",
        metavar="FUNCTION",
        help="print where a function's figures come from, step by step",
    )


def add_fail_on(parser: argparse.ArgumentParser) -> None:
    """Add the findings on which a run fails."""
    from typing import get_args

    from tracerisk.config import FailOn

    kinds = get_args(FailOn)
    words = f"exit 1 if the run has findings, or those of a kind: {', '.join(kinds)}"
    parser.add_argument("--fail-on", metavar="KIND", choices=kinds, help=words)


def add_mission_time(parser: argparse.ArgumentParser) -> None:
    """Add the mission time of a tree or a chain."""
    parser.add_argument(
        "--mission-time",
        dest="mission_time_h",
        metavar="H",
        type=positive,
        help="of a tree or a ctmc: how long it is in use, in hours",
    )


def add_max_failure_probability(parser: argparse.ArgumentParser, words: str) -> None:
    """Add the limit of a failure probability, under its older name too."""
    parser.add_argument(
        "--max-failure-probability", "--max-risk", metavar="P", type=probability, help=words
    )


def add_max_undetected_probability(parser: argparse.ArgumentParser) -> None:
    """Add the limit of the failures that nobody notices."""
    parser.add_argument(
        "--max-undetected-probability",
        metavar="P",
        type=probability,
        help="exit 1 if a mission fails unnoticed, or does harm before it stops, with more than P",
    )


def add_write_options(parser: argparse.ArgumentParser) -> None:
    """Add how sources are written."""
    group = parser.add_argument_group("what is written")
    group.add_argument(
        "--check", action="store_true", help="write no source; exit 1 if one would change"
    )
    group.add_argument(
        "--diff", action="store_true", help="write no source; print what would change"
    )


def add_edit_options(parser: argparse.ArgumentParser) -> None:
    """Add what becomes of a user's edits."""
    group = parser.add_argument_group("values edited by hand")
    either = group.add_mutually_exclusive_group()
    either.add_argument(
        "--accept-edits", action="store_true", help="keep values edited by hand, as := values"
    )
    either.add_argument(
        "--discard-edits",
        action="store_true",
        help="overwrite values edited by hand with computed ones",
    )
    group.add_argument(
        "--fresh", action="store_true", help="also rewrite values within the tolerance"
    )


def add_live(parser: argparse.ArgumentParser) -> None:
    """Add the options of a run on real ROS."""
    group = parser.add_argument_group("a live run")
    group.add_argument(
        "--live",
        action="store_true",
        help="run it on the installed ROS, with the twin as a node on loopback; writes no source",
    )
    group.add_argument(
        "--speed",
        metavar="X",
        type=positive,
        help="with --live: at most X times as fast as the wall clock (1)",
    )


def live_speed(options: argparse.Namespace) -> float | None:
    """Return how fast a run on real ROS may go; `None` for a run on the stand-ins."""
    if options.live and options.cpu_limit_s is not None:
        raise InputError(
            "--cpu-limit goes with runs on the stand-ins; a live run, which waits for other "
            "processes, is ended by --wall-limit"
        )
    if options.speed is not None and not options.live:
        raise InputError("--speed goes with --live; a run on the stand-ins is as fast as it can be")
    return (options.speed or 1.0) if options.live else None


def run_settings(options: argparse.Namespace) -> dict[str, Any]:
    """Return the options that override settings; those not given are `None`."""
    names = (
        "robot",
        "scene",
        "scenario",
        "launch",
        "companions",
        "draft",
        "hardware",
        "system",
        "active",
        "fail_on",
        "duration_s",
        "cpu_limit_s",
        "wall_limit_s",
        "stall_limit_s",
        "memory_limit_mb",
        "seed",
        "mission_cycles",
        "sandbox",
    )
    lists = {"params": "params", "drivers": "drivers", "args": "argv", "answers": "answers"}
    return {
        **{name: getattr(options, name, None) for name in names},
        **{name: tuple(getattr(options, given, ())) or None for name, given in lists.items()},
    }


def merge_policy(options: argparse.Namespace) -> MergePolicy:
    """Return what becomes of a user's edits."""
    from tracerisk.adder.merge.edits_found import MergePolicy

    if options.accept_edits:
        return MergePolicy("accept", options.fresh)
    return MergePolicy("discard" if options.discard_edits else "stop", options.fresh)
