"""The order in which states leave a sparse chain: the one with the fewest new ways first.

Amestoy, Davis, Duff, "An approximate minimum degree ordering algorithm", SIAM Journal on Matrix
Analysis and Applications 17 (1996): a quotient graph, in which an eliminated state stands for
all the ways that it left behind, with bounds of the degrees in place of the degrees.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tracerisk.prm.markov.large.compiling import compiled_by_numba

Array = np.ndarray[Any, Any]

TOO_DENSE = -1
"""In place of the start of the dense rest: elimination would fill in beyond the budget."""


@compiled_by_numba
def _compacted(
    pool: Array, spare: Array, start: Array, length: Array, n: int
) -> tuple[Array, Array, int]:
    """Copy all lists that are alive to `spare`; return it, the old pool and where it ends."""
    end = 0
    for i in range(n):
        if start[i] >= 0:
            first = start[i]
            start[i] = end
            for t in range(first, first + length[i]):
                spare[end] = pool[t]
                end += 1
    return spare, pool, end


@compiled_by_numba
def minimum_degree(
    n: int, indptr: Array, indices: Array, largest_rest: int, products: float
) -> tuple[Array, int]:
    """Return an elimination order of a symmetric pattern, and where its dense rest begins.

    The rest, in which each state is joined to half of the others or more, is left in the order
    of its indices.
    The start is `TOO_DENSE` when the rest would have more than `largest_rest` states, or
    elimination would take more than about `products` products before it.
    """
    order = np.empty(n, np.int32)
    if n == 0:
        return order, 0
    capacity = len(indices) + len(indices) // 5 + n + 1
    pool = np.empty(capacity, np.int32)
    spare = np.empty(capacity, np.int32)
    pool[: len(indices)] = indices
    end = len(indices)
    start = indptr[:n].copy()
    length = np.empty(n, np.int64)
    elements = np.zeros(n, np.int64)  # of each list, how many of its first are elements
    weight = np.ones(n, np.int64)  # states merged into this one; negative while in the pivot
    degree = np.empty(n, np.int64)
    is_element = np.zeros(n, np.bool_)
    stamp = np.zeros(n, np.int64)
    base = 1
    mark = np.full(n, -1, np.int64)
    marks = 0
    first_of = np.full(n, -1, np.int32)  # the states of each degree, doubly linked
    after = np.full(n, -1, np.int32)
    before = np.full(n, -1, np.int32)
    member_after = np.full(n, -1, np.int32)
    member_last = np.arange(n).astype(np.int32)
    hash_first = np.full(n, -1, np.int32)
    hash_after = np.full(n, -1, np.int32)
    hash_of = np.zeros(n, np.int64)

    # States joined to very many others only slow the ordering down: they go last.
    many = max(16, int(10.0 * np.sqrt(n)))
    remaining = n
    hubs = 0
    for i in range(n):
        length[i] = indptr[i + 1] - indptr[i]
        degree[i] = length[i]
        if length[i] > many:
            weight[i] = 0
            start[i] = -1
            hubs += 1
            order[n - hubs] = i
    order[n - hubs :] = order[n - hubs :][::-1].copy()
    remaining = n - hubs
    for i in range(n - 1, -1, -1):
        if weight[i]:
            d = min(degree[i], n - 1)
            degree[i] = d
            after[i] = first_of[d]
            if first_of[d] >= 0:
                before[first_of[d]] = i
            first_of[d] = i

    placed = 0
    least = 0
    while remaining:
        while first_of[least] < 0:
            least += 1
        if 2 * least >= remaining and remaining > 1:
            break
        # Each state that is left leads to so many others, and most of them to more.
        if least > largest_rest or float(remaining) * least * least > products:
            return order, TOO_DENSE
        p = first_of[least]
        first_of[least] = after[p]
        if after[p] >= 0:
            before[after[p]] = -1

        # The pivot's neighbours: those of its own and of the elements that it takes over.
        needed = length[p]
        for t in range(start[p], start[p] + elements[p]):
            needed += length[pool[t]]
        # Each neighbour stands once in the new list, and all lists together only get shorter.
        if end + min(needed, n) > capacity:
            pool, spare, end = _compacted(pool, spare, start, length, n)
        own = weight[p]
        weight[p] = -own
        is_element[p] = True
        lead = end
        for t in range(start[p], start[p] + length[p]):
            source = pool[t]
            if t < start[p] + elements[p]:
                left = start[source]
                right = left + length[source]
            else:
                left = t
                right = t + 1
            for s in range(left, right):
                i = pool[s]
                if weight[i] > 0:
                    weight[i] = -weight[i]
                    pool[end] = i
                    end += 1
                    if before[i] >= 0:
                        after[before[i]] = after[i]
                    else:
                        first_of[degree[i]] = after[i]
                    if after[i] >= 0:
                        before[after[i]] = before[i]
            if t < start[p] + elements[p]:
                start[source] = -1
        start[p] = lead
        length[p] = end - lead
        elements[p] = 0
        size = 0
        for s in range(lead, end):
            size -= weight[pool[s]]

        # How much of each other element lies outside of the pivot.
        base += n + 1
        for s in range(lead, end):
            i = pool[s]
            for t in range(start[i], start[i] + elements[i]):
                e = pool[t]
                if start[e] < 0:
                    continue
                if stamp[e] < base:
                    stamp[e] = base + degree[e]
                stamp[e] += weight[i]

        for s in range(lead, end):
            i = pool[s]
            put = start[i]
            outside = 0
            code = np.int64(p)
            for t in range(start[i], start[i] + elements[i]):
                e = pool[t]
                if start[e] >= 0 and e != p:
                    beyond = stamp[e] - base
                    if beyond > 0:
                        outside += beyond
                        pool[put] = e
                        put += 1
                        code += e
                    else:
                        start[e] = -1
            new_elements = put - start[i]
            for t in range(start[i] + elements[i], start[i] + length[i]):
                j = pool[t]
                if weight[j] > 0:
                    outside += weight[j]
                    pool[put] = j
                    put += 1
                    code += j
            if outside == 0:
                # Joined to nobody but the pivot's neighbours: it can leave with the pivot.
                own -= weight[i]
                size += weight[i]
                weight[i] = 0
                start[i] = -1
                member_after[member_last[p]] = i
                member_last[p] = member_last[i]
                continue
            # A place is free: the pivot, or an element that it took over, stood here.
            pool[put] = pool[start[i] + new_elements]
            pool[start[i] + new_elements] = p
            elements[i] = new_elements + 1
            length[i] = put + 1 - start[i]
            degree[i] = min(degree[i], outside)
            code %= n
            hash_of[i] = code
            hash_after[i] = hash_first[code]
            hash_first[code] = i

        # States with the same neighbours stay so: they are one from now on.
        for s in range(lead, end):
            i = pool[s]
            if weight[i] == 0:
                continue
            i = hash_first[hash_of[i]]
            if i < 0:
                continue
            hash_first[hash_of[i]] = -1
            while i >= 0:
                if weight[i] != 0 and hash_after[i] >= 0:
                    marks += 1
                    for t in range(start[i], start[i] + length[i]):
                        mark[pool[t]] = marks
                    previous = i
                    j = hash_after[i]
                    while j >= 0:
                        same = length[j] == length[i] and elements[j] == elements[i]
                        if same:
                            for t in range(start[j], start[j] + length[j]):
                                if mark[pool[t]] != marks:
                                    same = False
                                    break
                        if same:
                            weight[i] += weight[j]
                            weight[j] = 0
                            start[j] = -1
                            member_after[member_last[i]] = j
                            member_last[i] = member_last[j]
                            hash_after[previous] = hash_after[j]
                        else:
                            previous = j
                        j = hash_after[j]
                i = hash_after[i]

        remaining -= own
        keep = lead
        for s in range(lead, end):
            i = pool[s]
            if weight[i] == 0:
                continue
            weight[i] = -weight[i]
            d = min(degree[i] + size - weight[i], remaining - weight[i])
            d = max(d, 0)
            degree[i] = d
            before[i] = -1
            after[i] = first_of[d]
            if first_of[d] >= 0:
                before[first_of[d]] = i
            first_of[d] = i
            least = min(least, d)
            pool[keep] = i
            keep += 1
        end = keep
        length[p] = keep - lead
        degree[p] = size
        weight[p] = 0
        if keep == lead:
            start[p] = -1
        i = p
        while i >= 0:
            order[placed] = i
            placed += 1
            i = member_after[i]

    # What is left is joined nearly all to all.
    rest = placed
    if n - placed > 0:
        taken = np.zeros(n, np.bool_)
        for t in range(placed):
            taken[order[t]] = True
        for i in range(n):
            if not taken[i]:
                order[placed] = i
                placed += 1
    if n - rest > largest_rest:
        return order, TOO_DENSE
    return order, rest
