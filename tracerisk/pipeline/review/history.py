"""How a controller's risk went over the commits of git, from the blocks alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from tracerisk.adder.lock.lock import LOCK_NAME
from tracerisk.config import controller_root
from tracerisk.errors import InputError, Location, TraceRiskError
from tracerisk.pipeline.history.repository import Repository
from tracerisk.pipeline.review.controllers import ControllerVersion, ReviewedController, version_of
from tracerisk.pipeline.review.git_versions import WORKING_TREE, GitVersion
from tracerisk.pipeline.review.review import difference
from tracerisk.pipeline.review.run_verdicts import version_verdict
from tracerisk.prm.review.risk_change import RiskDiff
from tracerisk.report.series.history import HistoryRow
from tracerisk.trace import Verdict

_FORMAT = "--format=%x01%H%x00%cs%x00%s"
_NOTHING = ControllerVersion({}, None, ".")


@dataclass(frozen=True, slots=True)
class HistoryPoint:
    """A controller after one commit that changed it."""

    commit: str
    """The hash; empty for the working tree."""
    date: str
    """Of the commit, as 2026-11-23; empty for the working tree."""
    subject: str
    path: str
    """Where its script is, from the top of the repository."""
    failure_probability: float | None
    """Of a mission by hardware; `None` where it has no blocks, or none that can be read."""
    verdict: Verdict | None
    """Of the run behind the blocks; `None` where it is unknown."""
    diff: RiskDiff | None = None
    """What the commit did to the risk; `None` where nothing of it changed."""
    error: str = ""
    """Why its blocks cannot be read, in words."""

    @property
    def is_news(self) -> bool:
        """Whether it says something: another risk, another verdict, or that it cannot be read."""
        if self.diff is None:
            return bool(self.error)
        verdicts = self.diff.verdicts
        is_judged = verdicts is not None and verdicts.before != verdicts.after
        return not self.diff.is_unchanged or is_judged

    @property
    def name(self) -> str:
        """What a table calls it."""
        return self.commit[:8] or WORKING_TREE


def history(controller: Path, *, most: int | None = None) -> list[HistoryPoint]:
    """Return how the risk of a controller went, the oldest first; of `most` last commits.

    A commit counts that changed the script, followed through renames, another of its sources, or
    its lock so that its blocks or its verdict differ. The working tree comes last where it differs.
    Raises InputError outside a repository, and for a file that git does not know.
    """
    path = controller.resolve()
    if not path.exists():
        raise InputError(
            "does not exist; name a controller of the working tree", Location(str(controller))
        )
    with Repository.opened(path.parent) as repository:
        top = repository.top.resolve()
        name = path.relative_to(top).as_posix()
        return list(_points(repository, top, name, controller, most))


def _points(
    repository: Repository, top: Path, name: str, controller: Path, most: int | None
) -> Iterator[HistoryPoint]:
    commits = _commits(repository, top, name, controller, most)
    if not commits:
        raise InputError("git has no commit of it; commit it first", Location(str(controller)))
    # What the last point had, with which the next is compared: small rises add up.
    before, was = _NOTHING, ""
    last = _NOTHING
    for commit in [*commits, _Commit("", "", "", name)]:
        here = WORKING_TREE if not commit.hash else commit.hash[:8]
        version = GitVersion(repository, here, f"{here}:", commit.hash or None)
        try:
            after = version_of(version, commit.path)
        except TraceRiskError as error:
            yield HistoryPoint(*commit.plain, None, None, error=error.message)
            continue
        if (after.sources, after.entry) == (last.sources, last.entry):
            continue
        point = _point(commit, before, after, was)
        if point.is_news:
            yield point
        if not point.error:
            last = after
            if point.is_news:
                before, was = after, commit.path


@dataclass(frozen=True, slots=True)
class _Commit:
    hash: str
    date: str
    subject: str
    path: str

    @property
    def plain(self) -> tuple[str, str, str, str]:
        return self.hash, self.date, self.subject, self.path


def _commits(
    repository: Repository, top: Path, name: str, controller: Path, most: int | None
) -> list[_Commit]:
    """Return the commits that may have changed a controller, the oldest first."""
    number = () if most is None else (f"--max-count={most}",)
    followed = list(
        _logged(
            repository.output(
                *("log", "--follow", "--name-status", "-z", _FORMAT, *number, "--", name)
            )
        )
    )
    lock = controller_root(controller).resolve() / LOCK_NAME
    beside = lock.relative_to(top).as_posix() if lock.is_relative_to(top) else LOCK_NAME
    of_lock = _logged(
        repository.output("log", "--name-status", "-z", _FORMAT, *number, "--", beside)
    )
    order = repository.output("rev-list", "--topo-order", "HEAD").decode().split()
    rank = {each: index for index, each in enumerate(order)}
    known = {each.hash: each for each in followed}
    for each in of_lock:
        known.setdefault(each.hash, _Commit(each.hash, each.date, each.subject, ""))
    ordered = sorted(known.values(), key=lambda each: rank.get(each.hash, 0))
    found, path = [], name
    # From the newest back: a commit of the lock alone has the path that the next one found.
    for each in ordered:
        path = each.path or path
        found.append(_Commit(each.hash, each.date, each.subject, path))
    return found[:most][::-1]


def _logged(raw: bytes) -> Iterator[_Commit]:
    """Yield the commits of a log with the path that each has of its only file."""
    for part in raw.decode(errors="surrogateescape").split("\1")[1:]:
        digest, date, rest = part.split("\0", 2)
        fields = rest.split("\0")
        subject, _, status = fields[0].partition("\n")
        names = [each for each in fields[1:] if each]
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


def history_rows(points: Sequence[HistoryPoint]) -> list[HistoryRow]:
    """Return the commits as tables, charts and pages show them."""
    return [
        HistoryRow(
            each.name,
            each.date,
            each.subject,
            each.failure_probability,
            each.verdict,
            each.diff,
            each.error,
        )
        for each in points
    ]


def largest_rise(points: Sequence[HistoryPoint]) -> tuple[HistoryPoint, float] | None:
    """Return the commit after which the figure rose by the greatest factor, with the factor."""
    best: tuple[HistoryPoint, float] | None = None
    last: float | None = None
    for each in points:
        figure = each.failure_probability
        if figure is None:
            continue
        if last is not None and last > 0.0 and figure > last:
            factor = figure / last
            if best is None or factor > best[1]:
                best = each, factor
        last = figure
    return best


def first_above(points: Sequence[HistoryPoint], limit: float) -> HistoryPoint | None:
    """Return the commit since which the figure is above a limit; `None` where it is not above."""
    since: HistoryPoint | None = None
    for each in points:
        if each.failure_probability is None:
            continue
        if each.failure_probability <= limit:
            since = None
        elif since is None:
            since = each
    return since
