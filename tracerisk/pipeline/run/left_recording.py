"""What the process of a run left in its folder, with what it was given and has read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from tracerisk.common.sandbox.process import import_paths, regular_within
from tracerisk.common.settings.python_here import changed_python
from tracerisk.errors import Location, LogError
from tracerisk.instrument.recording import Note, Recording, read_recording
from tracerisk.pipeline.launch.program import shown
from tracerisk.pipeline.run.run_folders import check_left
from tracerisk.pipeline.trace.run_files import AROUND, EVENTS, LAUNCH, READ, STARTED, RunRequest

_COMPILED = frozenset({".pyc", ".so"})


def left_recording(folder: Path, request: RunRequest) -> Recording:
    """Return what the process of a run has left; it was able to put anything there.

    Raises LimitError where a file is too large, LogError where one is malformed, or speaks of
    sources outside of the workspace.
    """
    check_left(folder)
    events = folder / EVENTS
    recording = read_recording(events) if events.exists() else Recording()
    files = {site.ref.file for site in recording.functions_ran}
    commands = (*recording.commands, *recording.refused)
    files |= {frame.function.file for command in commands for frame in command.stack}
    root = Path(request.root)
    within = list(map(Path, request.readable))
    known = regular_within((str(root / name) for name in files), within)
    if request.written is not None and len(known) < len(files):
        strange = sorted(name for name in files if root / name not in known)
        raise LogError(
            f"speaks of {strange[0]}, which is not a file of the workspace", Location(EVENTS)
        )
    # What it was given is not for it to say.
    notes = tuple(note for note in recording.notes if note.kind != LAUNCH)
    lines = [*request.launch_notes, *(companion.line for companion in request.companions)]
    files_read = [] if request.launch is None else list(request.launch.sources)
    files_read += [file for companion in request.companions for file in companion.files]
    for item in recording.notes:
        if item.kind == AROUND and (read := regular_within(map(str, item.data["files"]), within)):
            given = shown(read, root)
            line = (
                f"launch: parameter {item.data['name']} from {given[0]}, which starts other "
                "nodes; --no-launch leaves it out"
            )
            lines += [] if line in lines else [line]
            files_read += given
    used, opened = _read_files(recording, request, within)
    lines += used
    if changed := changed_python():
        names = ", ".join(line.partition(" ")[0] for line in changed)
        lines.append(
            f"start: {names} of PYTHONPATH changed the Python in which tracerisk computes: its "
            "figures are those of that Python, and another finds them out of date"
        )
    files_read += opened
    if (lines or files_read) and recording.note(STARTED) is not None:
        inputs = tuple(dict.fromkeys(files_read))
        missing = () if request.launch is None else request.launch.missing
        noted = {"notes": tuple(lines), "inputs": inputs, "missing": missing}
        notes += (Note(LAUNCH, noted),)
    return replace(recording, notes=notes)


def _read_files(
    recording: Recording, request: RunRequest, within: Sequence[Path]
) -> tuple[list[str], tuple[str, ...]]:
    """Return lines on what a run read from elsewhere, and all files that it read.

    Those of the workspace are among them. Compiled code has a line wherever it is.
    """
    note = recording.note(READ) or {"files": ()}
    on_path = list(map(Path, import_paths()))
    read = regular_within(map(str, note["files"]), [*within, *on_path])
    lines = []
    for prefix in request.prefixes:
        count = sum(file.is_relative_to(prefix.path) for file in read)
        if count:
            what = "1 file" if count == 1 else f"{count} files"
            lines.append(f"installed: {what} of {prefix.path} ({prefix.found_in})")
    root = Path(request.root)
    around = {*regular_within(map(str, read), within)}
    if others := shown([file for file in read if file not in around], root):
        lines.append(
            f"import: {', '.join(others)} came from Python's path (PYTHONPATH, or a package that "
            "is installed as a link), from outside of the workspace"
        )
    if compiled := shown([file for file in read if file.suffix in _COMPILED], root):
        lines.append(
            f"import: {', '.join(compiled)} is compiled code: none of its functions is a step, and "
            "what it commands is not covered"
        )
    return lines, shown(read, root)
