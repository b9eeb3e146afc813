"""Options that several verbs share."""

from __future__ import annotations

import re

from tracerisk.common.campaign import CampaignOptions
from tracerisk.errors import InputError

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable, Mapping
    from fractions import Fraction
    from typing import Any

    from tracerisk.adder.merge.merge import MergePolicy

_WEIGHT = re.compile(r"\d{1,40}(?:/0*[1-9]\d{0,39}|\.\d{1,40})?|\.\d{1,40}")
_COLON = re.compile(r"(?<!:):(?!:)")

ProfileText = dict[str, dict[str, str]]


def add(group: argparse._ActionsContainer, text: str, **more: Mapping[str, Any]) -> None:
    """Add arguments and options that are written as help lists them.

    Each begins a line: its names, what it takes, two blanks, and words that go on in lines that
    are set in. An option that takes `FILE ...` is repeatable; an argument is `FILE`, `[FILE]`,
    `FILE ...` or `[FILE ...]`; `{a,b}` are all that is allowed. `as NAME` is where the value goes.

    What is taken is read by `_READERS`. `more` is what else `add_argument` is to know, by name.
    """
    entries: dict[str, list[str]] = {}
    for line in text.splitlines():
        if not line.startswith(" "):
            head, _, line = line.partition("  ")
            entries[head] = words = []
        words += line.split()
    for head, words in entries.items():
        stated, _, kept = head.partition(" as ")
        names, taken = _names_of(stated)
        given: dict[str, Any] = {"help": " ".join(words).replace("%", "%%")}
        if kept:
            given["dest"] = kept
        if taken.startswith("{"):
            given["choices"] = taken.strip("{}").split(",")
        elif not names[0].startswith("-"):
            given |= {"metavar": taken.strip("[]").removesuffix(" ..."), "nargs": _number_of(taken)}
        elif taken.endswith(" ..."):
            given |= {"metavar": taken.removesuffix(" ..."), "action": "append", "default": []}
        elif taken:
            given |= {"metavar": taken, "type": _READERS.get(taken)}
        else:
            given["action"] = "store_true"
        name = next((each for each in names if each.startswith("--")), names[0])
        group.add_argument(*names, **{**given, **more.get(name.lstrip("-").replace("-", "_"), {})})


def _names_of(stated: str) -> tuple[list[str], str]:
    """Return the names of an option, or of an argument, and what it takes."""
    words = stated.split()
    count = sum(word.startswith("-") for word in words) or 1
    return [word.rstrip(",") for word in words[:count]], " ".join(words[count:])


def _number_of(taken: str) -> str | None:
    """Return how many values an argument takes, as `argparse` has it."""
    if taken.endswith("...]"):
        return "*"
    return "?" if taken.startswith("[") else "+" if taken.endswith("...") else None


_EVERYWHERE = """\
--json        print the result as JSON
-q, --quiet   print only errors and what was asked for
--color WHEN  always, never or auto: on a terminal, as NO_COLOR and FORCE_COLOR say (auto)
"""


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add `--json`, `--quiet` and `--color`."""
    when = ("auto", "always", "never")
    add(parser, _EVERYWHERE, color={"choices": when, "default": "auto"})


def add_sarif(parser: argparse.ArgumentParser) -> None:
    """Add `--sarif`."""
    add(parser, "--sarif FILE  write what was found as SARIF, for code scanning")


_RECORD = """\
--record OUT.mcap  write the run as an MCAP file (docs/recordings.md)
--record-rate HZ   how often joint states are written into it, 50 to 500 (500)
"""


def add_record(parser: argparse.ArgumentParser) -> None:
    """Add the recording of the run as a file for other tools."""
    add(parser, _RECORD, record_rate={"default": 500.0})


_GIVEN = """\
--robot NAME|FILE  robot to simulate (default: inferred from joint and group names)
--scene NAME|FILE  scene to simulate (default: that of the robot)
--scenario FILE    scenario: messages, services and objects around the controller
                   (docs/scenario.md)
--params FILE ...  parameters as YAML, of ROS 1 or ROS 2; repeatable
--driver FILE ... as drivers
                   a description of what the robot's driver serves; repeatable
"""
_LAUNCH = """\
--launch FILE          launch file that starts the controller (default: searched for)
--no-launch as launch  ignore launch files
"""
_LIMITED = """\
--no-companions as companions
                     do not start workspace nodes that the controller depends on
--no-draft as draft  do not assume missing inputs; a run that needs one ends without a trace
--duration S as duration_s
                     simulated time after which the run is over (300 s)
--cpu-limit S as cpu_limit_s
                     processor time after which the controller is stopped (120 s)
--wall-limit S as wall_limit_s
                     wall time after which it is stopped (1800 s)
--stall-limit S as stall_limit_s
                     time it computes or sleeps without simulated progress, and that of each
                     process that reads a launch, xacro or model file (30 s)
--memory-limit MB as memory_limit_mb
                     address space of the controller's process (8192 MB)
--mission-cycles N   cycles per mission assumed for a controller that loops forever (10)
"""
_REPEATED = """\
--seed N    seed of all that is random (0)
--answer TEXT ... as answers
            an answer for input(), in turn; then Enter
--keep DIR  keep the recording of the run in a folder
"""


def add_run_options(parser: argparse.ArgumentParser, *, needs_file: bool = True) -> None:
    """Add the controller, which may be left out without `needs_file`, and what its run needs."""
    file = "FILE" if needs_file else "[FILE]"
    add(parser, f"controller {file}  the controller's Python file")
    add(parser, "argv [ARG ...]  arguments for the controller, after --")
    group = parser.add_argument_group("the run")
    left_out = {"action": "store_const", "const": False}
    add(group, _GIVEN)
    add(group.add_mutually_exclusive_group(), _LAUNCH, no_launch=left_out)
    cycles = {"type": _cycles}
    add(group, _LIMITED, no_companions=left_out, no_draft=left_out, mission_cycles=cycles)
    add_sandbox(group)
    add(group, _REPEATED)
    add(group, "--log FILE  write the log in the published text format")


_SANDBOX = """\
--sandbox MODE  contain what is run of the workspace: where that works (auto), always and by no
                setting widened (require), never (off)
"""


def add_sandbox(group: argparse._ActionsContainer) -> None:
    """Add the option for the sandbox of what is run of a workspace."""
    add(group, _SANDBOX, sandbox={"choices": ("auto", "require", "off")})


_HARDWARE = """\
--hardware FILE  hardware description (default: that of the robot)
--active {...}   which time counts: moving, or also holding and grasping (moving+holding)
"""


def add_hardware_options(parser: argparse.ArgumentParser) -> None:
    """Add what turns use into probabilities."""
    from typing import get_args

    from tracerisk.config import ActiveMode

    group = parser.add_argument_group("the hardware")
    add(group, _HARDWARE, active={"choices": get_args(ActiveMode)})


_PROFILE = """\
--profile FUNCTION:TARGET=SHARE,... ...
    what follows a function, and how often: place:init=0.9,done=0.1; or a file by `tracerisk field`
"""


def add_profile(parser: argparse.ArgumentParser) -> None:
    """Add the operational profile."""
    add(parser, _PROFILE)


_CAMPAIGN = """\
--time SECONDS  begin no further {thing} after this; the same command goes on from there
-j, --jobs N    processes (default: one a core)
--shard I/N     try every N-th {thing} alone
--fresh         try again what was tried before
"""


def add_campaign_options(group: argparse._ActionsContainer, thing: str) -> None:
    """Add what all that is run in many parts has: `--time`, `-j`, `--shard`, `--fresh`."""
    add(group, _CAMPAIGN.format(thing=thing), shard={"default": (1, 1)})


def campaign_options(
    options: argparse.Namespace,
    progress: Callable[[int, int, float], None] | None,
    noted: Callable[[str], None] | None = None,
) -> CampaignOptions:
    """Return how the runs of a campaign are carried out."""
    return CampaignOptions(
        jobs=options.jobs,
        most_s=options.time,
        shard=options.shard,
        fresh=options.fresh,
        progress=progress,
        noted=noted,
    )


def _shard(text: str) -> tuple[int, int]:
    index, slash, of = text.partition("/")
    if slash and index.isdecimal() and of.isdecimal() and len(of) <= 5:
        found = int(index), int(of)
        if 1 <= found[0] <= found[1] <= 10_000:
            return found
    raise _refused(f"'{text}': expected I/N such as 1/4, I from 1 to N")


def add_explain(parser: argparse.ArgumentParser) -> None:
    """Add the function whose figures are derived."""
    add(parser, "--explain FUNCTION  print where a function's figures come from, step by step")


def add_fail_on(parser: argparse.ArgumentParser) -> None:
    """Add the findings on which a run fails."""
    from typing import get_args

    from tracerisk.config import FailOn

    kinds = get_args(FailOn)
    words = f"exit 1 if the run has findings, or those of a kind: {', '.join(kinds)}"
    add(parser, f"--fail-on KIND  {words}", fail_on={"choices": kinds})


_MISSION_TIME = """\
--mission-time H as mission_time_h
    of a tree or a ctmc: how long it is in use, in hours
"""


def add_mission_time(parser: argparse.ArgumentParser) -> None:
    """Add the mission time of a tree or a chain."""
    add(parser, _MISSION_TIME)


def add_max_failure_probability(parser: argparse.ArgumentParser, words: str) -> None:
    """Add the limit of a failure probability, under its older name too."""
    add(parser, f"--max-failure-probability, --max-risk P  {words}")


_WRITE = """\
--check  write no source; exit 1 if one would change
--diff   write no source; print what would change
"""


def add_write_options(parser: argparse.ArgumentParser) -> None:
    """Add how sources are written."""
    add(parser.add_argument_group("what is written"), _WRITE)


_EDITS = """\
--accept-edits   keep values edited by hand, as := values
--discard-edits  overwrite values edited by hand with computed ones
"""


def add_edit_options(parser: argparse.ArgumentParser) -> None:
    """Add what becomes of a user's edits."""
    group = parser.add_argument_group("values edited by hand")
    add(group.add_mutually_exclusive_group(), _EDITS)
    add(group, "--fresh  also rewrite values that changed by less than 1 %")


_LIVE = """\
--live     run it on the installed rospy, with the twin as a node on loopback; writes no source
--speed X  with --live: at most X times as fast as the wall clock (1)
"""


def add_live(parser: argparse.ArgumentParser) -> None:
    """Add the options of a run on real rospy."""
    add(parser.add_argument_group("on real rospy"), _LIVE)


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
    lists = {"params": "params", "drivers": "drivers", "args": "argv", "answers": "answers"}
    return {
        **{name: getattr(options, name, None) for name in names},
        **{name: tuple(getattr(options, given, ())) or None for name, given in lists.items()},
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

            from tracerisk.common.field.file import read_field

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


_READERS: Mapping[str, Callable[[str], Any]] = {
    **dict.fromkeys(("K", "MB", "N"), count),
    **dict.fromkeys(("F", "P"), probability),
    **dict.fromkeys(("H", "S", "SECONDS", "WIDTH", "X"), positive),
    **dict.fromkeys(("HZ", "RAD"), float),
    "I/N": _shard,
    "PERCENT": percentage,
}
"""How what an option takes is read, by what stands for it; all else is text."""
