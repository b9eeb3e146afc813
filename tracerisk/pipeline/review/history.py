"""How a controller's risk went over the commits of git, from the blocks alone."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from tracerisk.adder.lock.lock import LOCK_NAME
from tracerisk.config import controller_root
from tracerisk.errors import InputError, Location, TraceRiskError
from tracerisk.pipeline.history.repository import Repository
from tracerisk.pipeline.review.controllers import (
    ControllerVersion,
    Locks,
    ReviewedController,
    version_of,
)
from tracerisk.pipeline.review.git_versions import GitVersion
from tracerisk.pipeline.review.review import difference
from tracerisk.pipeline.review.run_verdicts import version_verdict
from tracerisk.prm.review.risk_diff import WORKING_TREE
from tracerisk.report.series.history import HistoryPoint

_FORMAT = "--format=%x01%H%x00%cs%x00%s"
_NOTHING = ControllerVersion({}, None, ".")


def history(controller: Path, *, most: int | None = None) -> list[HistoryPoint]:
    """Return how the risk of a controller went, as `histories` does of many."""
    return histories([controller], most=most)[0]


def histories(
    controllers: Sequence[Path], *, most: int | None = None
) -> tuple[list[HistoryPoint], ...]:
    """Return how the risk of each controller went, the oldest first; of `most` last commits.

    A commit counts that changed the script, followed through renames, another of its sources, or
    its lock so that its blocks or its verdict differ. The working tree comes last where it differs.
    Raises InputError outside a repository, and for a file that git does not know.
    """
    walks = [_Walk(controller) for controller in controllers]
    for walk in walks:
        if not walk.path.exists():
            raise InputError(
                "does not exist; name a controller of the working tree",
                Location(str(walk.controller)),
            )
    tops: dict[Path, Path] = {}
    for folder in dict.fromkeys(walk.path.parent for walk in walks):
        with Repository.opened(folder) as repository:
            tops[folder] = repository.top.resolve()
    for top in dict.fromkeys(tops.values()):
        here = [walk for walk in walks if tops[walk.path.parent] == top]
        with Repository.opened(top) as repository:
            _go(repository, top, here, most)
    return tuple(walk.points for walk in walks)


def is_cut_short(controllers: Sequence[Path]) -> bool:
    """Return whether git lacks older commits of a controller: it lies in a shallow clone."""
    for folder in dict.fromkeys(controller.resolve().parent for controller in controllers):
        with Repository.opened(folder) as repository:
            if repository.is_shallow:
                return True
    return False


class _State(NamedTuple):
    """What is known of a controller after one of its commits."""

    last: ControllerVersion
    """The version of that commit."""
    before: ControllerVersion
    """The version of the last row up to it, with which the next is compared: small rises add up."""
    was: str
    """The path of the script in that row, from the top."""


class _Walk:
    """What is known of a controller on the way from its oldest commit to the working tree."""

    def __init__(self, controller: Path) -> None:
        self.controller = controller
        self.path = controller.resolve()
        self.points: list[HistoryPoint] = []
        self._states: dict[str, _State] = {}
        # What the last row shows.
        self._shown = _NOTHING

    def step(self, commit: _Commit, locks: Locks, parents: Mapping[str, Sequence[str]]) -> None:
        """Go on to a commit, which is compared with its own first parent."""
        old = self._parent(commit, locks, parents)
        self._states[commit.hash] = old
        try:
            after = version_of(locks, commit.path)
        except TraceRiskError as error:
            self.points.append(HistoryPoint(*commit.plain, None, None, error=error.message))
            return
        # The last row is that of what is here, and not of a branch that was merged into it.
        is_elsewhere = not commit.hash and self._shown is not old.before
        if (after.sources, after.entry) == (old.last.sources, old.last.entry) and not is_elsewhere:
            return
        point = _point(commit, old.before, after, old.was)
        if point.is_news or is_elsewhere:
            self.points.append(point)
            self._shown = after
        if not point.error:
            row = (after, commit.path) if point.is_news else (old.before, old.was)
            self._states[commit.hash] = _State(after, *row)

    def _parent(
        self, commit: _Commit, locks: Locks, parents: Mapping[str, Sequence[str]]
    ) -> _State:
        first = parents[commit.hash][:1]
        known = self._nearest(first, parents)
        if len(known) == 1 or not self._states or not first:
            return self._states[known[0]] if known else _State(_NOTHING, _NOTHING, "")
        # Below a merge several are near, of which the parent has what one has, or what both made.
        version = GitVersion(locks.version.repository, first[0][:8], f"{first[0][:8]}:", first[0])
        try:
            now = version_of(Locks(version), commit.path)
        except TraceRiskError:
            return self._states[known[0]] if known else _State(_NOTHING, _NOTHING, "")
        for item in known:
            state = self._states[item]
            if (state.last.sources, state.last.entry) == (now.sources, now.entry):
                return state
        return _State(now, now, commit.path)

    def _nearest(self, ahead: Sequence[str], parents: Mapping[str, Sequence[str]]) -> list[str]:
        """Return the nearest commits of the controller from some of the repository backwards."""
        found: dict[str, None] = {}
        seen: set[str] = set()
        left = deque(ahead)
        while left:
            here = left.popleft()
            if here in seen:
                continue
            seen.add(here)
            if here in self._states:
                found[here] = None
            else:
                left += parents.get(here, ())
        return list(found)


def _go(repository: Repository, top: Path, walks: Sequence[_Walk], most: int | None) -> None:
    """Go through the commits of a repository once, with all controllers."""
    if repository.read("HEAD^{commit}") is None:
        raise InputError("has no commit yet; commit first", Location(str(top)))
    listed = repository.output("rev-list", "--topo-order", "--parents", "HEAD").decode()
    lines = [line.split() for line in listed.splitlines()]
    parents = {words[0]: words[1:] for words in lines}
    # The working tree has no hash.
    parents[""] = list(parents)[:1]
    log = _Log(repository, {words[0]: rank for rank, words in enumerate(lines)}, most)
    steps: list[tuple[_Commit, _Walk]] = []
    for walk in walks:
        name = walk.path.relative_to(top).as_posix()
        commits = log.commits(top, name, walk.controller)
        if not commits:
            raise InputError(
                "git has no commit of it; commit it first", Location(str(walk.controller))
            )
        steps += [(item, walk) for item in commits]
    steps.sort(key=lambda step: -log.rank.get(step[0].hash, 0))
    steps += [(_Commit("", "", "", walk.path.relative_to(top).as_posix()), walk) for walk in walks]
    # A lock with many controllers takes long to read, so that each is read once.
    for digest, group in itertools.groupby(steps, key=lambda step: step[0].hash):
        here = digest[:8] or WORKING_TREE
        locks = Locks(GitVersion(repository, here, f"{here}:", digest or None))
        for commit, walk in group:
            walk.step(commit, locks, parents)


@dataclass(frozen=True, slots=True)
class _Commit:
    hash: str
    """The hash of the commit; empty for the working tree."""
    date: str
    """The date of the commit, `YYYY-MM-DD`; empty for the working tree."""
    subject: str
    """The first line of its message; empty for the working tree."""
    path: str
    """The path of the controller in the commit, from the top; empty where only the lock changed."""

    @property
    def plain(self) -> tuple[str, str, str, str]:
        return self.hash, self.date, self.subject, self.path


class _Log:
    """The commits of a repository; `rank` is the place of each, the newest first."""

    def __init__(self, repository: Repository, rank: Mapping[str, int], most: int | None) -> None:
        self.rank = rank
        self._repository = repository
        self._most = most
        self._of_locks: dict[str, list[_Commit]] = {}

    def commits(self, top: Path, name: str, controller: Path) -> list[_Commit]:
        """Return the commits that may have changed a controller, the oldest first."""
        lock = controller_root(controller).resolve() / LOCK_NAME
        beside = lock.relative_to(top).as_posix() if lock.is_relative_to(top) else LOCK_NAME
        if beside not in self._of_locks:
            self._of_locks[beside] = self._logged(beside)
        known = {commit.hash: commit for commit in self._logged(name, "--follow")}
        for of_locks in self._of_locks[beside]:
            known.setdefault(of_locks.hash, replace(of_locks, path=""))
        ordered = sorted(known.values(), key=lambda commit: self.rank.get(commit.hash, 0))
        result, path = [], name
        # From the newest back: a commit of the lock alone has the path that the next one found.
        for commit in ordered:
            path = commit.path or path
            result.append(replace(commit, path=path))
        return result[: self._most][::-1]

    def _logged(self, name: str, *options: str) -> list[_Commit]:
        number = () if self._most is None else (f"--max-count={self._most}",)
        words = ("log", *options, "--name-status", "-z", _FORMAT, *number, "--", name)
        return list(_logged(self._repository.output(*words)))


def _logged(raw: bytes) -> Iterator[_Commit]:
    """Yield the commits of a log with the path that each has of its only file."""
    for part in raw.decode(errors="surrogateescape").split("\1")[1:]:
        digest, date, rest = part.split("\0", 2)
        fields = rest.split("\0")
        subject, _, status = fields[0].partition("\n")
        names = [field for field in fields[1:] if field]
        if not status and names:
            status = names.pop(0)
        yield _Commit(digest, date, subject.strip(), names[-1] if names else "")


def _point(
    commit: _Commit, before: ControllerVersion, after: ControllerVersion, was: str
) -> HistoryPoint:
    moved = was if was and was != commit.path else None
    try:
        diff = difference(ReviewedController(commit.path, moved, before, after), None)
        verdict = version_verdict(after)
    except TraceRiskError as error:
        return HistoryPoint(*commit.plain, None, None, error=error.message)
    figure = None if diff.after is None else diff.after.failure_probability
    return HistoryPoint(*commit.plain, figure, verdict, diff)


def largest_rise(points: Sequence[HistoryPoint]) -> tuple[HistoryPoint, float] | None:
    """Return the commit after which the figure rose by the greatest factor, with the factor.

    Only figures count that can be compared.
    """
    best: tuple[HistoryPoint, float] | None = None
    for point in points:
        figure, before = point.failure_probability, point.figure_before
        if figure is None or not before or figure <= before or not point.is_comparable:
            continue
        factor = figure / before
        if best is None or factor > best[1]:
            best = point, factor
    return best


def wrong_since(points: Sequence[HistoryPoint]) -> HistoryPoint | None:
    """Return the commit since which runs go wrong or never end; `None` if the last is well."""
    since: HistoryPoint | None = None
    for point in points:
        is_wrong = point.verdict is not None and point.verdict.is_bad
        since = (since or point) if is_wrong else None
    return since


def last_other_result(points: Sequence[HistoryPoint]) -> HistoryPoint | None:
    """Return the newest commit that changed what the mission brings about, if any did."""
    return next((point for point in reversed(points) if point.outcome_mark == "result"), None)


def first_above(points: Sequence[HistoryPoint], limit: float) -> HistoryPoint | None:
    """Return the commit since which the figure is above a limit; `None` where it is not above."""
    since: HistoryPoint | None = None
    for point in points:
        if point.failure_probability is None:
            continue
        if point.failure_probability <= limit:
            since = None
        elif since is None:
            since = point
    return since
