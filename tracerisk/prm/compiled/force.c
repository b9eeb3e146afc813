/* Orders of variables by FORCE, compiled: tracerisk/prm/trees/bdd/force.py says what it gives. */

#include <stdlib.h>

#include "loops.h"

struct drawn { /* a node, and where it is drawn to */
    double to;
    double node;
};

static int earlier(const void *first, const void *second)
{
    const struct drawn *a = first, *b = second;
    if (a->to != b->to)
        return a->to < b->to ? -1 : 1;
    return a->node < b->node ? -1 : 1;
}

static void rank(struct drawn *all, int64_t size, double *place)
{
    qsort(all, (size_t)size, sizeof *all, earlier);
    for (int64_t at = 0; at < size; at++)
        place[(int64_t)all[at].node] = (double)at;
}

LOOP void draw(int64_t rounds, INTEGERS(offsets), INTEGERS(members), FLOATS(place), FLOATS(best),
               INTEGERS(counts), FLOATS(pairs))
{
    struct drawn *all = (struct drawn *)pairs;
    double least = -1.0;
    for (int64_t at = 0; at < members_size; at++)
        counts[members[at]]++;
    for (int64_t node = 0; node < place_size; node++) {
        all[node].to = place[node];
        all[node].node = (double)node;
    }
    rank(all, place_size, place);
    for (int64_t round = 0; round < rounds; round++) {
        double span = 0.0;
        for (int64_t node = 0; node < place_size; node++) {
            all[node].to = 0.0;
            all[node].node = (double)node;
        }
        for (int64_t group = 0; group + 1 < offsets_size; group++) {
            int64_t start = offsets[group], end = offsets[group + 1];
            double first = place[members[start]], last = first, sum = 0.0;
            for (int64_t at = start; at < end; at++) {
                double here = place[members[at]];
                first = here < first ? here : first;
                last = here > last ? here : last;
                sum += here;
            }
            span += last - first;
            double mean = sum / (double)(end - start);
            for (int64_t at = start; at < end; at++)
                all[members[at]].to += mean;
        }
        if (least < 0.0 || span < least) {
            least = span;
            for (int64_t node = 0; node < place_size; node++)
                best[node] = place[node];
        }
        for (int64_t node = 0; node < place_size; node++)
            all[node].to /= counts[node];
        rank(all, place_size, place);
    }
}
