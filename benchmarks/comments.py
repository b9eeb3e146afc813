"""What the comment on a pull request says of changes that occur most, as a page and a picture.

    python benchmarks/comments.py [--page docs/comments.md] [--picture docs/pictures/comments.png]

A little repository with one controller, its settings and hardware description is made, run and
committed; each change is made in a copy of it, run where its author would have run it, committed,
and compared by `tracerisk diff`. The picture needs chromium; without --page and --picture the
comments are printed. The same tracerisk gives the same page.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import quick

SAMPLE = Path(__file__).parents[1] / "sample_controllers" / "pick_and_place.py"
CELL = "cell.py"
SETTINGS = '[tool.tracerisk]\nscene = "tube_racks"\nhardware = "hw.yaml"\n'
HARDWARE = """\
robot: panda
source: IEC 61709
components:
  power_system:
    failure_rate: {value: 4.0e-6, per: hour}
    quantity: 2
    redundancy: true
    active: always
  gripper:
    failure_rate: {value: 4.4e-6, per: hour}
    twin: {gripper: true}
  electric_motor:
    failure_rate: {value: 2.1e-7, per: hour}
    quantity: 7
    twin: {joints: "*"}
"""
REPOSITORY = "https://github.com/OWNER/cell/blob"
IGNORED = ".tracerisk_cache\n"
WIDTH = 1660
"""The width of the picture [px]; its height is what the comments take."""
COLOURS = 32

Edit = Callable[[Path], None]


@dataclass(frozen=True)
class Change:
    """A change of the repository."""

    title: str
    """What its author would call it."""
    edits: tuple[Edit, ...]
    """What is changed in the files, in order."""
    verb: str = "refresh"
    """How the author brings the blocks up to date; empty where nobody did."""
    files: tuple[str, ...] = (CELL,)
    """The controllers that are brought up to date."""
    later: tuple[Edit, ...] = ()
    """What is changed in the blocks afterwards."""


def replaced(before: str, after: str, file: str = CELL) -> Edit:
    """Return an edit that replaces a text wherever it is in a file; it has to be there."""

    def edit(folder: Path) -> None:
        text = (folder / file).read_text(encoding="utf-8")
        if before not in text:
            raise SystemExit(f"{file} has no {before!r}")
        (folder / file).write_text(text.replace(before, after), encoding="utf-8")

    return edit


def pinned(function: str, component: str, value: str) -> Edit:
    """Return an edit that sets a probability by hand, with a reason."""

    def edit(folder: Path) -> None:
        text = (folder / CELL).read_text(encoding="utf-8")
        block = text.index(f"name = {function}\n")
        entry = text.index(f"name = {component}\n", block)
        line = re.compile(r"probability = (\S+)").search(text, entry)
        assert line is not None, f"{component} of {function} has a probability"
        by_hand = f"probability := {value}  ! computed {line[1]}; supplier derating, FMEA-112"
        (folder / CELL).write_text(text[: line.start()] + by_hand + text[line.end() :], "utf-8")

    return edit


def copied(folder: Path) -> None:
    """Add a second controller, the first without its blocks and with half of its work."""
    strip = [sys.executable, "-m", "tracerisk", "strip", "wipe.py"]
    shutil.copy(folder / CELL, folder / "wipe.py")
    subprocess.run(strip, cwd=folder, check=True, capture_output=True)
    replaced("TUBES = 2", "TUBES = 1", "wipe.py")(folder)


REFACTORED = (
    replaced(
        "    arm.set_pose_target(slot(number, SOURCE_RACK_Y, TRAVEL_HEIGHT))\n"
        "    arm.go(wait=True)\n    arm.stop()\n    arm.clear_pose_targets()\n",
        "    go_to(arm, slot(number, SOURCE_RACK_Y, TRAVEL_HEIGHT))\n",
    ),
    replaced(
        "    arm.set_pose_target(slot(number, TARGET_RACK_Y, TRAVEL_HEIGHT))\n"
        "    arm.go(wait=True)\n    arm.stop()\n    arm.clear_pose_targets()\n",
        "    go_to(arm, slot(number, TARGET_RACK_Y, TRAVEL_HEIGHT))\n",
    ),
    replaced(
        "def init(arm, hand):",
        'def go_to(arm, pose):\n    """Go to a pose and rest there."""\n'
        "    arm.set_pose_target(pose)\n    arm.go(wait=True)\n    arm.stop()\n"
        "    arm.clear_pose_targets()\n\n\ndef init(arm, hand):",
    ),
)
MOTOR = "{value: 2.1e-7, per: hour}"
CHANGES = (
    Change("A comment in the code", (replaced("# Heights of", "# All heights of"),)),
    Change("Take a helper out of two steps", REFACTORED),
    Change(
        "Wait before the grasp",
        (
            replaced(
                '    hand.set_named_target("close")',
                '    rospy.sleep(20)\n    hand.set_named_target("close")',
            ),
        ),
    ),
    Change("Move four tubes instead of two", (replaced("TUBES = 2", "TUBES = 4"),)),
    Change("Move one tube less", (replaced("TUBES = 2", "TUBES = 1"),)),
    Change(
        "Place the tubes one slot further",
        (replaced("slot(number, TARGET_RACK_Y", "slot(number + 1, TARGET_RACK_Y"),),
    ),
    Change(
        "Another motor",
        (replaced(MOTOR, '{value: 3.0e-7, per: hour, source: "data sheet M-44"}', "hw.yaml"),),
    ),
    Change("Derate the gripper by hand", (), verb="", later=(pinned("pick", "gripper", "2e-07"),)),
    Change(
        "One power supply is enough",
        (replaced("    quantity: 2\n    redundancy: true\n", "    quantity: 1\n", "hw.yaml"),),
    ),
    Change(
        "A tool changer",
        (
            replaced(
                "  gripper:",
                "  tool_changer:\n"
                '    failure_rate: {value: 1.0e-6, per: hour, source: "data sheet TC-2"}\n'
                "    active: always\n  gripper:",
                "hw.yaml",
            ),
        ),
    ),
    Change("Call a step by a better name", (replaced("pick(arm, hand)", "take(arm, hand)"),)),
    Change("A second controller", (copied,), verb="run", files=("wipe.py",)),
    Change(
        "Carry the tubes lower",
        (replaced("TRAVEL_HEIGHT = 0.3384", "TRAVEL_HEIGHT = 0.24"),),
        "run",
    ),
    Change("Faster, and not run", (replaced("factor(0.5)", "factor(0.9)"),), verb=""),
    Change(
        "Another motor, and not run",
        (replaced(MOTOR, '{value: 3.0e-7, per: hour, source: "data sheet M-44"}', "hw.yaml"),),
        verb="",
    ),
    Change(
        "A check that stops the mission",
        (
            replaced(
                "        place(hand)\n",
                '        place(hand)\n        raise RuntimeError("no vacuum")\n',
            ),
        ),
        "run",
    ),
)


def git(folder: Path, *words: str) -> None:
    """Run git with an author and a date that are always the same, so that commits are."""
    who = {f"GIT_{role}_{what}": text for role in ("AUTHOR", "COMMITTER") for what, text in AUTHOR}
    alone = {"GIT_CONFIG_GLOBAL": os.devnull, "GIT_CONFIG_SYSTEM": os.devnull}
    command = ["git", "-C", str(folder), *words]
    subprocess.run(command, env={**os.environ, **who, **alone}, check=True, capture_output=True)


AUTHOR = (("NAME", "author"), ("EMAIL", "author@example.org"), ("DATE", "2026-01-01T00:00:00Z"))


def tracerisk(folder: Path, *words: str) -> str:
    """Return what a verb prints; a limit or a faulted run is no failure of it here."""
    command = [sys.executable, "-m", "tracerisk", *words]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode > 1:
        raise SystemExit(f"{' '.join(words)}: {done.stderr}")
    return done.stdout


def made(folder: Path) -> None:
    """Make the repository with its first commit."""
    source = SAMPLE.read_text(encoding="utf-8").replace("TUBES = 10", "TUBES = 2")
    source = re.sub(r"# /// script\n(?:#.*\n)*?# ///\n", "", source)
    for name, text in (
        (CELL, source.replace("ten test tubes", "two test tubes")),
        ("pyproject.toml", SETTINGS),
        ("hw.yaml", HARDWARE),
        (".gitignore", IGNORED),
    ):
        (folder / name).write_text(text, encoding="utf-8")
    tracerisk(folder, "run", "--quiet", CELL)
    git(folder, "init", "--quiet", "--initial-branch=main")
    git(folder, "add", "--all")
    git(folder, "commit", "--quiet", "--message=Move two tubes")


def comment_on(change: Change, base: Path, folder: Path) -> str:
    """Return the comment on a change, which is made in a copy of the repository."""
    shutil.copytree(base, folder)
    git(folder, "switch", "--quiet", "--create=change")
    for edit in change.edits:
        edit(folder)
    if change.verb:
        tracerisk(folder, change.verb, "--quiet", *change.files)
    for edit in change.later:
        edit(folder)
    git(folder, "add", "--all")
    git(folder, "commit", "--quiet", f"--message={change.title}")
    words = ("--format", "markdown", "--link-base", REPOSITORY, "main..change")
    return tracerisk(folder, "diff", *words)


def page_of(comments: Sequence[tuple[Change, str]]) -> str:
    """Return the page of the documentation with the texts."""
    lines = [
        "# Sixteen comments",
        "",
        "What `tracerisk diff --format markdown` says of a change, as a bot posts it on a pull "
        "request: the same little cell, changed in sixteen ways.",
        "`python benchmarks/comments.py` makes the repositories, this page and the picture.",
        "[Reviewing a change](review.md) explains what is reported.",
        "",
        "![The sixteen comments as a reviewer sees them](pictures/comments.png)",
    ]
    for change, text in comments:
        lines += ["", f"## {change.title}", "", "````markdown", text.rstrip("\n"), "````"]
    return "\n".join(lines) + "\n"


STYLE = """
* { box-sizing: border-box }
body { margin: 24px; background: #f6f8fa; color: #1f2328; columns: 2; column-gap: 20px;
  font: 14px/1.45 -apple-system, "Segoe UI", "Noto Sans", "DejaVu Sans", Helvetica, sans-serif }
section { break-inside: avoid; margin: 0 0 20px; background: #fff; border: 1px solid #d1d9e0;
  border-radius: 6px; overflow: hidden }
h2 { margin: 0; padding: 7px 14px; font-size: 13px; background: #eef1f4;
  border-bottom: 1px solid #d1d9e0 }
div { padding: 4px 14px } p, ul { margin: 8px 0 } ul { padding-left: 22px }
a { color: #0969da; text-decoration: none } summary { cursor: pointer }
table { border-collapse: collapse; margin: 8px 0; font-size: 12px }
th, td { border: 1px solid #d1d9e0; padding: 4px 8px; white-space: nowrap }
code { background: #eff1f3; border-radius: 4px; padding: 1px 4px; font-size: 12px }
"""


def draw(comments: Sequence[tuple[Change, str]], picture: Path) -> None:
    """Draw the comments as a browser shows them, in few colours."""
    from html import escape

    from markdown_it import MarkdownIt
    from PIL import Image

    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if browser is None:
        raise SystemExit("--picture needs chromium")
    render = MarkdownIt("commonmark", {"html": True}).enable("table").render
    cards = "".join(
        f"<section><h2>{escape(change.title)}</h2><div>{render(text)}</div></section>"
        for change, text in comments
    )
    with tempfile.TemporaryDirectory() as name:
        html, shot = Path(name, "page.html"), Path(name, "shot.png")
        html.write_text(
            f"<!doctype html><meta charset=utf-8><style>{STYLE}</style>{cards}", "utf-8"
        )
        options = (
            "--headless",
            "--no-sandbox",
            "--hide-scrollbars",
            f"--user-data-dir={name}/user",
        )
        size = f"--window-size={WIDTH},6000"
        command = [browser, *options, size, f"--screenshot={shot}", html.as_uri()]
        subprocess.run(command, check=True, capture_output=True)
        with Image.open(shot) as image:
            whole = image.convert("RGB")
            # Below the last comment there is nothing but background.
            plain = Image.new("RGB", whole.size, whole.getpixel((0, 0)))
            from PIL import ImageChops

            box = ImageChops.difference(whole, plain).getbbox()
            bottom = whole.height if box is None else min(whole.height, box[3] + 24)
            cut = whole.crop((0, 0, whole.width, bottom)).quantize(COLOURS)
            cut.save(picture, optimize=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--page", type=Path, help="write the page of the documentation")
    parser.add_argument("--picture", type=Path, help="draw the comments as a PNG")
    parser.add_argument("--most", type=int, default=len(CHANGES), help="so many changes")
    options = quick.parsed(parser, most=lambda: 2)
    comments = []
    with tempfile.TemporaryDirectory(prefix="comments-") as name:
        base = Path(name, "base")
        base.mkdir()
        made(base)
        for number, change in enumerate(CHANGES[: options.most]):
            comments.append((change, comment_on(change, base, Path(name, str(number)))))
    if options.page is not None:
        options.page.write_text(page_of(comments), encoding="utf-8")
    if options.picture is not None:
        draw(comments, options.picture)
    if options.page is None and options.picture is None:
        for change, text in comments:
            print(f"== {change.title}\n{text}")


if __name__ == "__main__":
    main()
