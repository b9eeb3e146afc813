"""Do something again whenever a file changes: `--watch`.

The files are few and known, so that their times are looked at ten times a second. That needs no
package, and sees on every file system what an editor does: writing, replacing, removing.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import NoReturn

from tracerisk.cli.shared.output import note
from tracerisk.errors import DependencyError, TraceRiskError

POLL_S = 0.1
"""How often files are looked at [s]."""
_SETTLED_S = 0.15
"""How long nothing may change before a change is taken [s]: editors write in several steps."""
_LOOK_S = 0.2
_ENDINGS = frozenset(
    (
        ".py",
        ".yaml",
        ".yml",
        ".toml",
        ".xml",
        ".launch",
        ".urdf",
        ".xacro",
        ".srdf",
        ".sysml",
        ".json",
    )
)

State = Mapping[Path, object]
"""What each file looks like: `None` for one that is not there."""


class SupersededError(Exception):
    """A file changed while the work for an earlier version of it was under way."""


class Watch:
    """The files that are watched, and how they looked when the work on them began."""

    def __init__(self, files: Iterable[Path]) -> None:
        self.files: tuple[Path, ...] = tuple(files)
        self._seen = state_of(self.files)
        self._looked_s = time.monotonic()

    def begin(self) -> None:
        """Take the files as they are now for those that the work is done on."""
        self._seen = state_of(self.files)

    def look(self) -> None:
        """Raise SupersededError where a file has changed; to be called often."""
        if time.monotonic() - self._looked_s >= _LOOK_S:
            self._looked_s = time.monotonic()
            if self.changed():
                raise SupersededError

    def follow(self, files: Iterable[Path]) -> None:
        """Watch other files: those that were watched already count as they were."""
        self.files = tuple(dict.fromkeys(files))
        self._seen = {
            **state_of(self.files),
            **{f: s for f, s in self._seen.items() if f in self.files},
        }

    def changed(self) -> tuple[Path, ...]:
        """Return the files that are not as they were when the work began."""
        now = state_of(self.files)
        return tuple(file for file in self.files if now[file] != self._seen.get(file))

    def wait(self) -> tuple[Path, ...]:
        """Wait until files have changed, and no more do; return which."""
        while not self.changed():
            time.sleep(POLL_S)
        now = state_of(self.files)
        while True:
            time.sleep(_SETTLED_S)
            before, now = now, state_of(self.files)
            if before == now:
                return self.changed()


def state_of(files: Collection[Path]) -> State:
    """Return what files look like; of a folder, the names of the sources in it."""
    return {file: _look(file) for file in files}


def _look(file: Path) -> object:
    try:
        stat = file.stat()
        if file.is_dir():
            return frozenset(
                path.name for path in file.iterdir() if path.suffix.lower() in _ENDINGS
            )
    except OSError:
        return None
    return stat.st_mtime_ns, stat.st_size, stat.st_ino


def note_error(error: TraceRiskError) -> None:
    """Print an error as the command does, and go on."""
    note(f"tracerisk: {error.with_code}")


def watch(
    files: Iterable[Path],
    update: Callable[[Watch], Iterable[Path]],
    *,
    quiet: bool,
    show_error: Callable[[TraceRiskError], None] = note_error,
    sources: Path | None = None,
) -> NoReturn:
    """Call `update` now, and whenever a file has changed; it ends by an interrupt.

    `update` returns the files to watch from then on. One that is superseded is called again.
    After an error the file that it names is watched too, and the sources in the folder `sources`.
    Raises DependencyError: no change of a file brings what is not installed.
    """
    watched = Watch(files)
    while True:
        watched.begin()
        try:
            watched.follow(update(watched))
        except SupersededError:
            note(f"{_named(watched.changed())} changed meanwhile; begun again", quiet=quiet)
            _settle(watched)
            continue
        except DependencyError:
            raise
        except TraceRiskError as error:
            show_error(error)
            place = [] if error.location is None else [Path(error.location.file)]
            beside = [] if sources is None else sources.glob("*.py")
            watched.follow({*watched.files, *place, *beside})
        count = sum(1 for file in watched.files if file.is_file())
        text = f"watching {count} file{'' if count == 1 else 's'}; Ctrl-C ends"
        note(text, quiet=quiet)
        note(f"{_named(watched.wait())} changed", quiet=quiet)


def _settle(watched: Watch) -> None:
    if watched.changed():
        watched.wait()


def _named(files: Collection[Path]) -> str:
    names = [file.name or str(file) for file in files if not file.is_dir()]
    names = names or [f"{file.resolve().name}/" for file in files]
    more = f" and {len(names) - 2} more" if len(names) > 2 else ""
    return ", ".join(names[:2]) + more if names else "a file"
