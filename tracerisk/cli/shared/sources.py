"""Read the files that verbs are given."""

from __future__ import annotations

import re
from collections.abc import Sequence

from tracerisk.cli.shared.output import note
from tracerisk.common.text.bounded import MOST_WRITTEN, named_file, read_within
from tracerisk.errors import InputError, Location, TooLargeError, readable

TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse
    from fractions import Fraction
    from pathlib import Path

    from tracerisk.config import Settings
    from tracerisk.prm.hybrid.hybrid import HybridModel
    from tracerisk.twin.robots.robot import Robot


_WEIGHT = re.compile(r"\d{1,40}(?:/0*[1-9]\d{0,39}|\.\d{1,40})?|\.\d{1,40}")
_COLON = re.compile(r"(?<!:):(?!:)")
ProfileText = dict[str, dict[str, str]]
"""For each function the share of each target, as text."""
_HAS_EVIDENCE = re.compile(rb"RiskAnnotation [^\n]*with evidence")


def read_file(name: str) -> bytes:
    """Return the bytes of a file; raise InputError when it cannot be read or holds too many."""
    with readable(name), named_file(name) as file:
        data = read_within(file, MOST_WRITTEN)
    if data is None:
        raise TooLargeError(
            f"{name}: holds more than {MOST_WRITTEN // 2**20} MB; no larger file is read"
        )
    return data


def model_of_sources(files: Sequence[str], profile: ProfileText) -> HybridModel:
    """Build the model of the blocks in the files."""
    from pathlib import Path

    from tracerisk.pipeline.model import build

    if len(set(files)) != len(files):
        raise InputError("a file is named twice; name each once")
    sources = {name: read_file(name) for name in files}
    name = "+".join(Path(file).name for file in files)
    if any(_HAS_EVIDENCE.search(source) for source in sources.values()):
        from tracerisk.config import controller_root
        from tracerisk.pipeline.freshness.used_evidence import edited_evidence

        note("blocks take evidence: they count only failures that ended the mission on the twin")
        for root in dict.fromkeys(controller_root(Path(file)) for file in files):
            for edited in edited_evidence(root):
                note(f"warning: {edited}")
    return build(sources, name=name, profile=_profile_fractions(profile))


def model_of_files(files: Sequence[str], profile: ProfileText) -> HybridModel:
    """Return the model that one JSON file holds, or that the blocks of sources make."""
    if len(files) == 1:
        data = read_file(files[0])
        if data.lstrip().startswith(b"{"):
            if profile:
                raise InputError("--profile goes with sources; a model file has its own `next`")
            from tracerisk.prm.formats import model_json

            return model_json.loads(decoded(data, files[0]), files[0])
    return model_of_sources(files, profile)


def named_robot(name: str, root: Path | None = None, settings: Settings | None = None) -> Robot:
    """Return a shipped robot by its name, or that of a model file.

    `settings` are those of `root`, by default of this folder.
    """
    from pathlib import Path

    from tracerisk.pipeline.robot.choice import read_model
    from tracerisk.pipeline.workspace.project import Project
    from tracerisk.twin.robots import added_gripper
    from tracerisk.twin.robots.robot import is_model_file

    if not is_model_file(name):
        return added_gripper.named_robot(name)
    here = Project((root or Path()).resolve())
    return read_model(here, name, (settings or here.settings()).limits).robot


def decoded(data: bytes, name: str, encoding: str = "utf-8") -> str:
    """Return the text of a file; raise InputError where it is none."""
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        raise InputError("is not UTF-8 text", Location(name)) from error


def read_profile(options: argparse.Namespace) -> ProfileText:
    """Return the profile as text: for each function the share of each target.

    Raises InputError when it is malformed.
    """
    profile: ProfileText = {}
    for text in options.profile:
        if text.endswith(".json"):
            from pathlib import Path

            from tracerisk.common.field.file import read_field

            shares = read_field(Path(text)).shares()
            if twice := sorted(shares.keys() & profile.keys()):
                raise InputError(f"--profile names '{twice[0]}' twice; give each function once")
            profile |= shares
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


def _profile_fractions(profile: ProfileText) -> dict[str, dict[str, Fraction]]:
    """Return the profile as exact fractions."""
    from fractions import Fraction

    return {
        function: {target: Fraction(share) for target, share in row.items()}
        for function, row in profile.items()
    }
