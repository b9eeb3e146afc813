"""How a campaign of runs is carried out: by whom, for how long, which part of it."""

from __future__ import annotations

from dataclasses import dataclass

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Executor


@dataclass(frozen=True, slots=True)
class CampaignOptions:
    """Who carries out the runs of a campaign, and which of them."""

    jobs: int | None = None
    """How many local processes run at a time; `None` for one a core."""
    executor: Executor | None = None
    """Whose workers carry out the runs in place of local processes."""
    most_s: float | None = None
    """After how long it ends, with what was done by then, [s] of wall time; `None` for no limit."""
    shard: tuple[int, int] = (1, 1)
    """Which part of the runs is carried out: (i, n) is every n-th one, from the i-th on."""
    fresh: bool = False
    """Whether runs that an earlier call has kept are carried out again."""
    progress: Callable[[int, int, float], None] | None = None
    """Called with how many runs are done, of how many, and the time left [s]."""
    noted: Callable[[str], None] | None = None
    """Called with each sentence that a user should know.

    A sentence says how many runs there are if they are more than asked for, what was edited in
    the evidence and is tried again, or why runs could not be branched off one and were whole ones.
    """

    def has(self, number: int) -> bool:
        """Return whether the run of a number, from 0, is in the shard."""
        index, of = self.shard
        return number % of == index - 1


DEFAULT_CAMPAIGN = CampaignOptions()
"""All runs, by one local process a core."""
