/* Approximate minimum degree: Amestoy, Davis, Duff 1996. tracerisk/prm/other_models/markov/large/ordering.py
   says what it gives. */

#include "loops.h"

enum { TOO_DENSE = -1 };

struct lists { /* of neighbours, in one pool that is compacted when it is full */
    int32_t *pool;
    int32_t *spare;
    int64_t *start;
    int64_t *length;
    int64_t end;
};

static void compacted(struct lists *lists, int64_t n)
{
    int64_t end = 0;
    for (int64_t i = 0; i < n; i++)
        if (lists->start[i] >= 0) {
            int64_t first = lists->start[i];
            lists->start[i] = end;
            for (int64_t t = first; t < first + lists->length[i]; t++)
                lists->spare[end++] = lists->pool[t];
        }
    int32_t *old = lists->pool;
    lists->pool = lists->spare;
    lists->spare = old;
    lists->end = end;
}

struct degrees { /* the states of each degree, doubly linked */
    int32_t *first_of;
    int32_t *after;
    int32_t *before;
};

static void enter(struct degrees *degrees, int32_t i, int64_t d)
{
    int32_t first = degrees->first_of[d];
    degrees->before[i] = -1;
    degrees->after[i] = first;
    if (first >= 0)
        degrees->before[first] = i;
    degrees->first_of[d] = i;
}

static void leave(struct degrees *degrees, int32_t i, int64_t d)
{
    int32_t before = degrees->before[i], after = degrees->after[i];
    if (before >= 0)
        degrees->after[before] = after;
    else
        degrees->first_of[d] = after;
    if (after >= 0)
        degrees->before[after] = before;
}

/* longs: (7 n) and ints: (9 n), scratch; pools: (2, capacity). */
LOOP int64_t minimum_degree(LONGS(indptr), INTEGERS(indices), int64_t many, int64_t largest_rest,
                            double products, INTEGERS(pools), LONGS(longs), INTEGERS(ints),
                            INTEGERS(order))
{
    int64_t n = order_size, capacity = pools_size / 2;
    int64_t *elements = longs + 2 * n; /* of each list, how many of its first are elements */
    int64_t *weight = longs + 3 * n;   /* states merged into this one; negative in the pivot */
    int64_t *degree = longs + 4 * n, *stamp = longs + 5 * n, *mark = longs + 6 * n;
    struct lists lists = {pools, pools + capacity, longs, longs + n, indices_size};
    struct degrees degrees = {ints, ints + n, ints + 2 * n};
    int32_t *member_after = ints + 3 * n, *member_last = ints + 4 * n;
    int32_t *hash_first = ints + 5 * n, *hash_after = ints + 6 * n, *hash_of = ints + 7 * n;
    int32_t *is_placed = ints + 8 * n;
    int64_t *start = lists.start, *length = lists.length;
    int64_t base = 1, marks = 0, hubs = 0;

    for (int64_t t = 0; t < indices_size; t++)
        lists.pool[t] = indices[t];
    for (int64_t i = 0; i < n; i++) {
        start[i] = indptr[i];
        length[i] = degree[i] = indptr[i + 1] - indptr[i];
        elements[i] = stamp[i] = 0;
        weight[i] = 1;
        mark[i] = -1;
        degrees.first_of[i] = degrees.after[i] = degrees.before[i] = -1;
        member_after[i] = hash_first[i] = hash_after[i] = -1;
        member_last[i] = (int32_t)i;
        hash_of[i] = 0;
        /* States joined to very many others only slow the ordering down: they go last. */
        is_placed[i] = 0;
        if (length[i] > many) {
            weight[i] = 0;
            start[i] = -1;
            hubs++;
        }
    }
    int64_t remaining = n - hubs;
    for (int64_t i = n - 1; i >= 0; i--)
        if (weight[i]) {
            if (degree[i] > n - 1)
                degree[i] = n - 1;
            enter(&degrees, (int32_t)i, degree[i]);
        }

    int64_t placed = 0, least = 0;
    while (remaining) {
        while (degrees.first_of[least] < 0)
            least++;
        if (2 * least >= remaining && remaining > 1)
            break;
        /* Each state that is left leads to so many others, and most of them to more. */
        if (least > largest_rest || (double)remaining * (double)least * (double)least > products)
            return TOO_DENSE;
        int32_t p = degrees.first_of[least];
        leave(&degrees, p, least);

        /* The pivot's neighbours: those of its own and of the elements that it takes over. */
        int64_t needed = length[p];
        for (int64_t t = start[p]; t < start[p] + elements[p]; t++)
            needed += length[lists.pool[t]];
        /* Each neighbour stands once in the new list, and all lists together only get shorter. */
        if (lists.end + (needed < n ? needed : n) > capacity)
            compacted(&lists, n);
        int32_t *pool = lists.pool;
        int64_t own = weight[p];
        weight[p] = -own;
        int64_t lead = lists.end, end = lead;
        for (int64_t t = start[p]; t < start[p] + length[p]; t++) {
            int64_t left = t, right = t + 1;
            int is_element = t < start[p] + elements[p];
            int32_t source = pool[t];
            if (is_element) {
                left = start[source];
                right = left + length[source];
            }
            for (int64_t s = left; s < right; s++) {
                int32_t i = pool[s];
                if (weight[i] > 0) {
                    weight[i] = -weight[i];
                    pool[end++] = i;
                    leave(&degrees, i, degree[i]);
                }
            }
            if (is_element)
                start[source] = -1;
        }
        start[p] = lead;
        length[p] = end - lead;
        elements[p] = 0;
        int64_t size = 0;
        for (int64_t s = lead; s < end; s++)
            size -= weight[pool[s]];

        /* How much of each other element lies outside of the pivot. */
        base += n + 1;
        for (int64_t s = lead; s < end; s++) {
            int32_t i = pool[s];
            for (int64_t t = start[i]; t < start[i] + elements[i]; t++) {
                int32_t e = pool[t];
                if (start[e] < 0)
                    continue;
                if (stamp[e] < base)
                    stamp[e] = base + degree[e];
                stamp[e] += weight[i];
            }
        }

        for (int64_t s = lead; s < end; s++) {
            int32_t i = pool[s];
            int64_t put = start[i], outside = 0, code = p;
            for (int64_t t = start[i]; t < start[i] + elements[i]; t++) {
                int32_t e = pool[t];
                if (start[e] >= 0 && e != p) {
                    int64_t beyond = stamp[e] - base;
                    if (beyond > 0) {
                        outside += beyond;
                        pool[put++] = e;
                        code += e;
                    } else
                        start[e] = -1;
                }
            }
            int64_t new_elements = put - start[i];
            for (int64_t t = start[i] + elements[i]; t < start[i] + length[i]; t++) {
                int32_t j = pool[t];
                if (weight[j] > 0) {
                    outside += weight[j];
                    pool[put++] = j;
                    code += j;
                }
            }
            if (outside == 0) {
                /* Joined to nobody but the pivot's neighbours: it can leave with the pivot. */
                own -= weight[i];
                size += weight[i];
                weight[i] = 0;
                start[i] = -1;
                member_after[member_last[p]] = i;
                member_last[p] = member_last[i];
                continue;
            }
            /* A place is free: the pivot, or an element that it took over, stood here. */
            pool[put] = pool[start[i] + new_elements];
            pool[start[i] + new_elements] = p;
            elements[i] = new_elements + 1;
            length[i] = put + 1 - start[i];
            if (degree[i] > outside)
                degree[i] = outside;
            code %= n;
            hash_of[i] = (int32_t)code;
            hash_after[i] = hash_first[code];
            hash_first[code] = i;
        }

        /* States with the same neighbours stay so: they are one from now on. */
        for (int64_t s = lead; s < end; s++) {
            int32_t i = pool[s];
            if (weight[i] == 0)
                continue;
            int32_t code = hash_of[i];
            i = hash_first[code];
            hash_first[code] = -1;
            for (; i >= 0; i = hash_after[i]) {
                if (weight[i] == 0 || hash_after[i] < 0)
                    continue;
                marks++;
                for (int64_t t = start[i]; t < start[i] + length[i]; t++)
                    mark[pool[t]] = marks;
                int32_t previous = i;
                for (int32_t j = hash_after[i]; j >= 0; j = hash_after[j]) {
                    int same = length[j] == length[i] && elements[j] == elements[i];
                    for (int64_t t = start[j]; same && t < start[j] + length[j]; t++)
                        same = mark[pool[t]] == marks;
                    if (same) {
                        weight[i] += weight[j];
                        weight[j] = 0;
                        start[j] = -1;
                        member_after[member_last[i]] = j;
                        member_last[i] = member_last[j];
                        hash_after[previous] = hash_after[j];
                    } else
                        previous = j;
                }
            }
        }

        remaining -= own;
        int64_t keep = lead;
        for (int64_t s = lead; s < end; s++) {
            int32_t i = pool[s];
            if (weight[i] == 0)
                continue;
            weight[i] = -weight[i];
            int64_t d = degree[i] + size - weight[i];
            if (d > remaining - weight[i])
                d = remaining - weight[i];
            if (d < 0)
                d = 0;
            degree[i] = d;
            enter(&degrees, i, d);
            if (least > d)
                least = d;
            pool[keep++] = i;
        }
        lists.end = keep;
        length[p] = keep - lead;
        degree[p] = size;
        weight[p] = 0;
        if (keep == lead)
            start[p] = -1;
        for (int32_t i = p; i >= 0; i = member_after[i]) {
            order[placed++] = i;
            is_placed[i] = 1;
        }
    }

    /* What is left is joined nearly all to all, and stands in the order of its indices. */
    int64_t head = placed;
    for (int32_t i = 0; i < n; i++)
        if (!is_placed[i])
            order[placed++] = i;
    return n - head > largest_rest ? TOO_DENSE : head;
}
