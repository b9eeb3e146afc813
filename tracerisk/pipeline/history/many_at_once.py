"""Share work on many controllers out among the cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

_WORTH_A_PROCESS = 20  # controllers that take as long as a process takes to start
_SHARES = 2  # of a process: each reads the files of its projects anew


def shared_out(
    work: Callable[[Sequence[Item]], list[Result]],
    items: Sequence[Item],
    *,
    jobs: int | None = None,
) -> list[Result]:
    """Return what `work` makes of items, one result for each, in their order.

    Many are shared out among as many processes as there are cores, or `jobs`; `work`, items and
    results must be such that another process can be given them.
    """
    count = min(jobs or os.cpu_count() or 1, len(items) // _WORTH_A_PROCESS)
    if count < 2:
        return work(items)
    # Not needed for a few files, where a hundredth of a second is felt.
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    with ProcessPoolExecutor(count, mp_context=get_context("fork")) as pool:
        size = -(-len(items) // (count * _SHARES))
        shares = [items[start : start + size] for start in range(0, len(items), size)]
        return [result for results in pool.map(work, shares) for result in results]
