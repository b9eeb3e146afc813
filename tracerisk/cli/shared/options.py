"""Options that several verbs share."""

from __future__ import annotations

from tracerisk.errors import InputError
from tracerisk.text.patterns import pattern

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from fractions import Fraction
    from typing import Any

    from tracerisk.adder.merge.merge import MergePolicy

_WEIGHT = pattern(r"\d{1,40}(?:/0*[1-9]\d{0,39}|\.\d{1,40})?|\.\d{1,40}")
_COLON = pattern(r"(?<!:):(?!:)")

ProfileText = dict[str, dict[str, str]]


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add `--json`, `--quiet` and `--color`."""
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    parser.add_argument(
        "-q", "--quiet", action="store_true", help="print only errors and what was asked for"
    )
    parser.add_argument(
        "--color",
        metavar="WHEN",
        choices=("auto", "always", "never"),
        default="auto",
        help="always, never or auto: on a terminal, as NO_COLOR and FORCE_COLOR say (auto)",
    )


def add_sarif(parser: argparse.ArgumentParser) -> None:
    """Add `--sarif`."""
    parser.add_argument(
        "--sarif", metavar="FILE", help="write what was found as SARIF, for code scanning"
    )


def add_record(parser: argparse.ArgumentParser) -> None:
    """Add the recording of the run as a file for other tools."""
    parser.add_argument(
        "--record", metavar="OUT.mcap", help="write the run as an MCAP file (docs/recordings.md)"
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
        help="the controller's Python file",
    )
    parser.add_argument(
        "argv", metavar="ARG", nargs="*", help="arguments for the controller, after --"
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
        help="scenario: messages, services and objects around the controller (docs/scenario.md)",
    )
    group.add_argument(
        "--params",
        metavar="FILE",
        action="append",
        help="parameters as YAML, of ROS 1 or ROS 2; repeatable",
    )
    group.add_argument(
        "--driver",
        dest="drivers",
        metavar="FILE",
        action="append",
        help="a description of what the robot's driver serves; repeatable",
    )
    launch = group.add_mutually_exclusive_group()
    launch.add_argument(
        "--launch",
        metavar="FILE",
        help="launch file that starts the controller (default: searched for)",
    )
    launch.add_argument(
        "--no-launch",
        dest="launch",
        action="store_const",
        const=False,
        help="ignore launch files",
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
        help="time it computes or sleeps without simulated progress, and that of each process "
        "that reads a launch, xacro or model file (30 s)",
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
        dest="mission_cycles",
        metavar="N",
        type=_cycles,
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
    add_log(group)


def add_sandbox(group: argparse._ActionsContainer) -> None:
    """Add the option for the sandbox of what is run of a workspace."""
    group.add_argument(
        "--sandbox",
        metavar="MODE",
        choices=("auto", "require", "off"),
        help="contain what is run of the workspace: where that works (auto), always and by no "
        "setting widened (require), never (off)",
    )


def add_log(group: argparse._ArgumentGroup) -> None:
    """Add the file for a log in the published format."""
    group.add_argument("--log", metavar="FILE", help="write the log in the published text format")


def add_hardware_options(parser: argparse.ArgumentParser) -> None:
    """Add what turns use into probabilities."""
    from typing import get_args

    from tracerisk.config import ActiveMode

    group = parser.add_argument_group("the hardware")
    group.add_argument(
        "--hardware", metavar="FILE", help="hardware description (default: that of the robot)"
    )
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


def add_campaign_options(group: argparse._ActionsContainer, thing: str) -> None:
    """Add what all that is run in many parts has: `--time`, `-j`, `--shard`, `--fresh`."""
    group.add_argument(
        "--time",
        metavar="SECONDS",
        type=positive,
        help=f"begin no further {thing} after this; the same command goes on from there",
    )
    group.add_argument(
        "-j", "--jobs", metavar="N", type=count, help="processes (default: one a core)"
    )
    group.add_argument(
        "--shard", metavar="I/N", type=_shard, default=(1, 1), help=f"try every N-th {thing} alone"
    )
    group.add_argument("--fresh", action="store_true", help="try again what was tried before")


def _shard(text: str) -> tuple[int, int]:
    index, slash, of = text.partition("/")
    if slash and index.isdecimal() and of.isdecimal() and len(of) <= 5:
        found = int(index), int(of)
        if 1 <= found[0] <= found[1] <= 10_000:
            return found
    raise _refused(f"'{text}': expected I/N such as 1/4, I from 1 to N")


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

    parser.add_argument(
        "--fail-on",
        metavar="KIND",
        choices=get_args(FailOn),
        help=f"exit 1 if the run has findings, or those of a kind: {', '.join(get_args(FailOn))}",
    )


def add_mission_time(parser: argparse.ArgumentParser) -> None:
    """Add the mission time of a tree or a chain."""
    parser.add_argument(
        "--mission-time",
        dest="mission_time_h",
        metavar="H",
        type=positive,
        help="of a tree or a ctmc: how long it is in use, in hours",
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
    choice = group.add_mutually_exclusive_group()
    choice.add_argument(
        "--accept-edits", action="store_true", help="keep values edited by hand, as := values"
    )
    choice.add_argument(
        "--discard-edits",
        action="store_true",
        help="overwrite values edited by hand with computed ones",
    )
    group.add_argument(
        "--fresh", action="store_true", help="also rewrite values that changed by less than 1 %%"
    )


def add_live(parser: argparse.ArgumentParser) -> None:
    """Add the options of a run on real rospy."""
    group = parser.add_argument_group("on real rospy")
    group.add_argument(
        "--live",
        action="store_true",
        help="run it on the installed rospy, with the twin as a node on loopback; writes no source",
    )
    group.add_argument(
        "--speed",
        metavar="X",
        type=positive,
        help="with --live: at most X times as fast as the wall clock (1)",
    )


def live_speed(options: argparse.Namespace) -> float | None:
    """Return how fast a run on real rospy may go; `None` for a run on the stand-ins."""
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
    lists = {name: getattr(options, name, None) for name in ("params", "drivers")}
    return {
        **{name: getattr(options, name, None) for name in names},
        **{name: None if given is None else tuple(given) for name, given in lists.items()},
        "args": tuple(getattr(options, "argv", ())) or None,
        "answers": tuple(getattr(options, "answers", ())) or None,
    }


def merge_policy(options: argparse.Namespace) -> MergePolicy:
    """Return what becomes of a user's edits."""
    from tracerisk.adder.merge.merge import MergePolicy

    if options.accept_edits:
        return MergePolicy("accept", options.fresh)
    return MergePolicy("discard" if options.discard_edits else "stop", options.fresh)


def read_profile(options: argparse.Namespace) -> ProfileText:
    """Return the profile as text: for each function the share of each target.

    Raises InputError when it is malformed.
    """
    profile: ProfileText = {}
    for text in options.profile:
        if text.endswith(".json"):
            from pathlib import Path

            from tracerisk.field.file import read_field

            found = read_field(Path(text)).shares()
            if twice := sorted(found.keys() & profile.keys()):
                raise InputError(f"--profile names '{twice[0]}' twice; give each function once")
            profile |= found
            continue
        # Two colons are part of a name in C++.
        function, *rest = _COLON.split(text, maxsplit=1)
        if not rest or not function:
            raise InputError(f"--profile {text}: expected FUNCTION:TARGET=SHARE,...")
        if function in profile:
            raise InputError(f"--profile names '{function}' twice; give each function once")
        profile[function] = {}
        for part in rest[0].split(","):
            target, equals, share = part.strip().rpartition("=")
            if not equals or not _WEIGHT.fullmatch(share) or target in profile[function]:
                raise InputError(
                    f"--profile {text}: '{part}' is not a target of its own with a share, "
                    "such as init=0.9 or init=9/10"
                )
            profile[function][target] = share
    return profile


def profile_fractions(profile: ProfileText) -> dict[str, dict[str, Fraction]]:
    """Return the profile as exact fractions."""
    from fractions import Fraction

    return {
        function: {target: Fraction(share) for target, share in row.items()}
        for function, row in profile.items()
    }


def _refused(message: str) -> Exception:
    """Return the error at which the parser says where it stands."""
    import argparse

    return argparse.ArgumentTypeError(message)


def probability(text: str) -> float:
    """Read a probability of the command line."""
    value = _number(text)
    if not 0.0 <= value <= 1.0:
        raise _refused(f"{text} is not a probability; allowed: 0 to 1")
    return value


def percentage(text: str) -> float:
    """Read a percentage of the command line, which may be above 100."""
    value = _number(text)
    if not 0.0 <= value < 1e9:
        raise _refused(f"{text} is not a percentage from 0 up")
    return value


def positive(text: str) -> float:
    """Read a number above 0 of the command line."""
    value = _number(text)
    if not 0.0 < value < 1e9:
        raise _refused(f"{text} is not a number above 0 and below 1e9")
    return value


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise _refused(f"{text!r} is not a number") from None


def _cycles(text: str) -> int:
    value = count(text)
    if value < 1:
        raise _refused(f"{text} is below 1")
    return value


def count(text: str) -> int:
    """Read a whole number of the command line, from 0 up."""
    if not text.isascii() or not text.isdigit() or len(text) > 18:
        raise _refused(f"{text!r} is not a whole number from 0 up")
    return int(text)
