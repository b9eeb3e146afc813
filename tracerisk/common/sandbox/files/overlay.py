"""Files as a contained controller sees them: it may write where it likes, and nothing of it stays.

What it writes goes into a folder of the run, and is read from there afterwards. That is a courtesy
to programs that write a log or a result: what keeps the rest of the machine as it is, is the
kernel. A program that goes past Python's own functions for files is refused what it writes.
"""

from __future__ import annotations

import contextlib
import functools
import io
import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from tracerisk.common.replaced_names import replaced
from tracerisk.common.sandbox.files.audit_events import listen
from tracerisk.common.sandbox.files.noted_reads import unnoted
from tracerisk.common.sandbox.files.replaced_functions import (
    OS_NAMES,
    Entries,
    inside,
    is_inside,
    places_of,
    standing_for,
)
from tracerisk.common.sandbox.loopback import address_text, is_of_run

BOUND = "bound to"
"""What a run could not do to an address where it has no network of its own."""
_NETWORK = {
    "socket.connect": "connected to",
    "socket.bind": BOUND,
    "socket.sendto": "sent to",
    "socket.sendmsg": "sent to",
}
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_SYSTEM = ("/dev/", "/proc/", "/sys/")
_HOMES = ("home", "Users")
_MOST_COPIED = 1024**3
_DESCRIPTORS = ("dir_fd", "src_dir_fd", "dst_dir_fd")

Denied = Callable[[str, str], None]
"""Called with what was refused: a verb in its past form (`read`), and a path or an address."""


class Overlay:
    """Redirects what is written to `folder`, but for what is below a `writable` folder."""

    def __init__(
        self,
        folder: str,
        writable: Sequence[str],
        denied: Denied,
        on_absent_home: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._folder = folder
        self._on_absent_home = on_absent_home
        self._assumed: set[str] = set()
        self._writable = tuple(os.path.realpath(text) for text in writable)
        self._denied = denied
        self._is_used = False
        self._gone: set[str] = set()
        self._real = {name: getattr(os, name) for name in OS_NAMES}
        self._open = io.open

    def moved(self, folder: str) -> None:
        """Go on in a copy of the folder."""
        self._folder = folder

    @contextlib.contextmanager
    def active(self) -> Iterator[None]:
        """Redirect while this is open, and report addresses to which nothing could be sent."""
        with replaced(places_of(self._functions())):
            self._watch_network()
            yield

    def _watch_network(self) -> None:
        def watch(event: str, arguments: tuple[Any, ...]) -> None:
            if len(arguments) > 1 and not is_inside():
                with inside():
                    if not is_of_run(event, *arguments[:2]):
                        self._denied(_NETWORK[event], address_text(arguments[1]))

        listen(_NETWORK, watch)

    def _functions(self) -> dict[str, Callable[..., Any]]:
        callables: dict[str, Callable[..., Any]] = {
            "io.open": self._io_open,
            "open": self._os_open,
            "rename": functools.partial(self._move, "rename"),
            "replace": functools.partial(self._move, "replace"),
            "link": functools.partial(self._link, "link"),
            "symlink": functools.partial(self._link, "symlink"),
            "listdir": self._listdir,
            "scandir": self._scandir,
        }
        for name in ("stat", "lstat", "access", "readlink", "chdir"):
            callables[name] = functools.partial(self._reading, name)
        for name in ("mkdir", "mkfifo"):
            callables[name] = functools.partial(self._within, self._making, name)
        for name in ("remove", "unlink", "rmdir"):
            callables[name] = functools.partial(self._within, self._removing, name)
        for name in ("truncate", "utime", "chmod"):
            callables[name] = functools.partial(self._within, self._changing, name)
        return {
            name: standing_for(self._real.get(name, self._open), function, self._by_the_given_path)
            for name, function in callables.items()
        }

    def _by_the_given_path(self, error: OSError, given: tuple[Any, ...]) -> None:
        """Name in an error the paths that the controller gave, not where they are redirected to."""
        for field in ("filename", "filename2"):
            named = getattr(error, field)
            if isinstance(named, str) and named.startswith(self._folder + os.sep):
                full = named.removeprefix(self._folder)
                same = (item for item in given[:2] if self._full(item, {}) == full)
                setattr(error, field, os.fsdecode(next(same, full)))

    def _full(self, path: Any, more: dict[str, Any]) -> str | None:
        """Return the full path of what is the overlay's business, `None` for what is not."""
        if isinstance(path, int) or any(
            more.get(descriptor) is not None for descriptor in _DESCRIPTORS
        ):
            return None
        try:
            text = os.fsdecode(path)
            folder, name = os.path.split(os.path.abspath(text))
        except (TypeError, ValueError, OSError):
            return None
        full = os.path.join(os.path.realpath(folder), name)
        if full.startswith(_SYSTEM) or any(
            full == word or full.startswith(word + os.sep) for word in self._writable
        ):
            return None
        return full

    def _over(self, full: str) -> str:
        return self._folder + full

    def _has(self, full: str) -> bool:
        """Return whether something was written there."""
        return self._is_used and self._exists(self._over(full))

    def _exists(self, path: str) -> bool:
        try:
            self._real["lstat"](path)
        except OSError:
            return False
        return True

    def _seen(self, full: str) -> str:
        """Return where what is seen at a path lies; where nothing is, a path without a file."""
        return self._over(full) if self._has(full) or self._is_gone(full) else full

    def _is_gone(self, full: str) -> bool:
        return bool(self._gone) and any(
            full == name or full.startswith(name + os.sep) for name in self._gone
        )

    def _target(self, full: str) -> str:
        """Return where to write what is meant for a path, with the folders around it."""
        over = self._over(full)
        folder = os.path.dirname(full)
        seen = self._seen(folder)
        is_there = os.path.isdir(folder) if seen == folder else self._exists(seen)
        if is_there or self._is_of_absent_home(folder):
            self._is_used = True
            self._make_folders(os.path.dirname(over))
        return over

    def _is_of_absent_home(self, folder: str) -> bool:
        """Return whether a folder is in a home that this machine lacks: that of the author.

        There the author's files would be, so a log has a place; it is reported once for each home.
        """
        parts = folder.split(os.sep)
        home = os.sep.join(parts[:3])
        if len(parts) < 3 or parts[1] not in _HOMES or self._exists(home):
            return False
        if home not in self._assumed:
            self._assumed.add(home)
            self._on_absent_home(home)
        return True

    def _make_folders(self, folder: str) -> None:
        missing = []
        while not self._exists(folder):
            missing.append(folder)
            folder = os.path.dirname(folder)
        for name in reversed(missing):
            self._real["mkdir"](name)

    def _appended(self, full: str) -> str:
        """Return where to write behind what a file holds, as a log does, which nobody reads."""
        with unnoted():
            return self._copied(full)

    def _copied(self, full: str) -> str:
        """Return where to change a file: a copy of it, if there is one."""
        over = self._target(full)
        if not self._exists(over) and not self._is_gone(full) and self._exists(full):
            with self._open(full, "rb") as source, self._open(over, "wb") as target:
                if os.fstat(source.fileno()).st_size > _MOST_COPIED:
                    raise OSError(27, "is too large to be changed in a sandbox", full)
                shutil.copyfileobj(source, target)
        return over

    def _io_open(self, file: Any, mode: str = "r", *args: Any, **more: Any) -> Any:
        full = self._full(file, {})
        if full is None:
            return self._open(file, mode, *args, **more)
        if isinstance(mode, str) and any(name in mode for name in "wax+"):
            if "x" in mode and self._exists(self._seen(full)):
                raise FileExistsError(17, "File exists", os.fsdecode(file))
            is_new, is_behind = "w" in mode or "x" in mode, "a" in mode and "+" not in mode
            make = self._target if is_new else self._appended if is_behind else self._copied
            place = make(full)
            self._refuse_folder(full, place)
            return self._open(place, mode, *args, **more)
        place = self._seen(full)
        with self._noting(full):
            return self._open(file if place == full else place, mode, *args, **more)

    def _refuse_folder(self, full: str, place: str) -> None:
        if not self._exists(place) and os.path.isdir(full) and not self._is_gone(full):
            raise IsADirectoryError(21, "Is a directory", full)

    def _os_open(self, path: Any, flags: int, *args: Any, **more: Any) -> int:
        full = self._full(path, more)
        if full is None:
            return int(self._real["open"](path, flags, *args, **more))
        place = self._seen(full)
        if flags & _WRITES and not (place == full and os.path.isdir(full)):
            if flags & os.O_EXCL and self._exists(place):
                raise FileExistsError(17, "File exists", os.fsdecode(path))
            if not flags & os.O_CREAT and not self._exists(place):
                raise FileNotFoundError(2, "No such file or directory", os.fsdecode(path))
            is_behind = flags & os.O_APPEND and not flags & os.O_RDWR
            make = self._appended if is_behind else self._copied
            place = self._target(full) if flags & os.O_TRUNC else make(full)
            return int(self._real["open"](place, flags, *args, **more))
        with self._noting(full):
            return int(self._real["open"](path if place == full else place, flags, *args, **more))

    @contextlib.contextmanager
    def _noting(self, full: str) -> Iterator[None]:
        try:
            yield
        except PermissionError:
            self._denied("read", full)
            raise

    def _reading(self, name: str, path: Any, *args: Any, **more: Any) -> Any:
        full = self._full(path, more) if self._is_used or self._gone else None
        place = full if full is None else self._seen(full)
        return self._real[name](path if place in (None, full) else place, *args, **more)

    def _within(
        self, change: Callable[..., None], name: str, path: Any, *args: Any, **more: Any
    ) -> None:
        """Change what is the overlay's business by `change`, all else as the real function does."""
        full = self._full(path, more)
        if full is None:
            self._real[name](path, *args, **more)
        else:
            change(name, full, path, *args, **more)

    def _making(self, name: str, full: str, path: Any, *_: Any, **__: Any) -> None:
        if self._exists(self._seen(full)):
            raise FileExistsError(17, "File exists", os.fsdecode(path))
        # A folder that could not be read could not be removed either.
        self._real[name](self._target(full))

    def _removing(self, name: str, full: str, path: Any, *_: Any, **__: Any) -> None:
        if self._has(full):
            self._real[name](self._over(full))
        elif not self._exists(self._seen(full)):
            raise FileNotFoundError(2, "No such file or directory", os.fsdecode(path))
        elif name == "rmdir" and self._listdir(path):
            raise OSError(39, "Directory not empty", os.fsdecode(path))
        elif name == "rmdir" and not os.path.isdir(full):
            raise NotADirectoryError(20, "Not a directory", os.fsdecode(path))
        elif name != "rmdir" and os.path.isdir(full) and not os.path.islink(full):
            raise IsADirectoryError(21, "Is a directory", os.fsdecode(path))
        if self._exists(full):
            self._gone.add(full)

    def _changing(self, name: str, full: str, _: Any, *args: Any, **more: Any) -> None:
        if name == "truncate":
            self._real[name](self._copied(full), *args, **more)
        else:
            self._real[name](self._seen(full), *args, **more)

    def _move(self, name: str, source: Any, target: Any, **more: Any) -> None:
        one, other = self._full(source, more), self._full(target, more)
        if one is None and other is None:
            self._real[name](source, target, **more)
            return
        if one is not None and not self._exists(self._seen(one)):
            raise FileNotFoundError(2, "No such file or directory", os.fsdecode(source))
        if one is not None and self._seen(one) == one and os.path.isdir(one):
            self._denied("renamed", one)
            raise PermissionError(13, "Permission denied", os.fsdecode(source))
        moved = os.fsdecode(source) if one is None else self._copied(one)
        place = os.fsdecode(target) if other is None else self._target(other)
        shutil.move(moved, place) if one is None else self._real[name](moved, place)
        if one is not None and self._exists(one):
            self._gone.add(one)

    def _link(self, name: str, source: Any, target: Any, *args: Any, **more: Any) -> None:
        full = self._full(target, more)
        place = target if full is None else self._target(full)
        if full is not None and self._exists(self._seen(full)):
            raise FileExistsError(17, "File exists", os.fsdecode(target))
        if name == "link":
            given = self._full(source, more)
            source = source if given is None else self._seen(given)
        self._real[name](source, place, *args, **more)

    def _listdir(self, path: Any = ".") -> list[Any]:
        full = self._full(path, {})
        if full is None:
            return list(self._real["listdir"](path))
        full = os.path.realpath(full)
        with self._noting(full):
            names = self._names(full)
        return [os.fsencode(name) for name in names] if isinstance(path, bytes) else names

    def _names(self, full: str) -> list[str]:
        table: dict[str, None] = {}
        if not self._is_gone(full) and (self._exists(full) or not self._has(full)):
            table.update(dict.fromkeys(self._real["listdir"](full)))
        if self._has(full):
            table.update(dict.fromkeys(self._real["listdir"](self._over(full))))
        return [
            name
            for name in table
            if not self._is_gone(os.path.join(full, name)) or self._has(os.path.join(full, name))
        ]

    def _scandir(self, path: Any = ".") -> Any:
        full = self._full(path, {})
        if full is None or not (self._is_used or self._gone):
            return self._real["scandir"](path)
        full = os.path.realpath(full)
        entries = []
        places = [name for name in (self._over(full), full) if self._exists(name)]
        left = set(self._names(full))
        for place in places:
            with self._real["scandir"](place) as result:
                for item in result:
                    if item.name in left:
                        left.discard(item.name)
                        entries.append(item)
        return Entries(entries)
