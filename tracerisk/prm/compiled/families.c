/* Families of sets, compiled: tracerisk/prm/trees/bdd/families.py says what each function does, and
   what its arguments are. */

#include "loops.h"

struct families {
    int32_t *level;
    int32_t *low;
    int32_t *high;
    int32_t *table;
    int64_t table_mask;
    int64_t count;
    int64_t budget;
};

struct known { /* an entry of the cache of `without` */
    int32_t f;
    int32_t g;
    int32_t result;
};

struct frame { /* of `without`, which waits for those below it */
    int32_t f;
    int32_t g;
    int32_t stage;
    int32_t high;
};

/* The node of a level and two families, or OUT_OF_NODES. */
static int64_t node_of(struct families *sets, int64_t level, int64_t low, int64_t high)
{
    if (high == 0)
        return low;
    int64_t slot = slot_of_node(level, low, high, sets->table_mask);
    int64_t node;
    while ((node = sets->table[slot]) != 0) {
        if (sets->low[node] == low && sets->high[node] == high && sets->level[node] == level)
            return node;
        slot = (slot + 1) & sets->table_mask;
    }
    if (sets->count >= sets->budget)
        return OUT_OF_NODES;
    node = sets->count++;
    sets->table[slot] = (int32_t)node;
    sets->level[node] = (int32_t)level;
    sets->low[node] = (int32_t)low;
    sets->high[node] = (int32_t)high;
    return node;
}

/* The sets of f that hold no set of g, or OUT_OF_NODES. */
static int64_t without(struct families *sets, struct known *cache, int64_t cache_mask,
                       struct frame *frames, int64_t f, int64_t g)
{
    const int32_t *level = sets->level, *low = sets->low, *high = sets->high;
    int64_t depth = 0;
    for (;;) {
        int64_t result;
        if (f == 0 || g == 1 || f == g)
            result = 0;
        else if (g == 0 || f == 1)
            result = f;
        else if (level[g] < level[f]) {
            g = low[g];
            continue;
        } else {
            const struct known *known = &cache[slot_of_pair(f, g, cache_mask)];
            if (known->f == f && known->g == g)
                result = known->result;
            else {
                struct frame waiting = {(int32_t)f, (int32_t)g, 0, 0};
                frames[depth++] = waiting;
                if (level[f] == level[g])
                    g = high[g];
                f = high[f];
                continue;
            }
        }
        for (;;) {
            if (depth == 0)
                return result;
            struct frame *frame = &frames[depth - 1];
            f = frame->f;
            g = frame->g;
            if (frame->stage == 0 && level[f] == level[g]) {
                /* f's sets with the element must contain no set of g without it, either. */
                frame->stage = 1;
                f = result;
                g = low[g];
                break;
            }
            if (frame->stage < 2) {
                frame->stage = 2;
                frame->high = (int32_t)result;
                if (level[f] == level[g])
                    g = low[g];
                f = low[f];
                break;
            }
            depth--;
            result = node_of(sets, level[f], result, frame->high);
            if (result == OUT_OF_NODES)
                return OUT_OF_NODES;
            struct known found = {(int32_t)f, (int32_t)g, (int32_t)result};
            cache[slot_of_pair(f, g, cache_mask)] = found;
        }
    }
}

LOOP int64_t minimal_solutions(int64_t root, INTEGERS(level), INTEGERS(low), INTEGERS(high),
                               INTEGERS(rising), INTEGERS(weight), int64_t most, INTEGERS(needed),
                               INTEGERS(family), INTEGERS(set_level), INTEGERS(set_low),
                               INTEGERS(set_high), INTEGERS(table), INTEGERS(cache),
                               INTEGERS(frames), INTEGERS(used))
{
    struct families sets = {set_level, set_low, set_high, table, table_size - 1, 2, set_level_size};
    int64_t columns = most + 1;
    set_level[0] = level[0];
    set_level[1] = level[0];
    needed[root * columns + most] = 1;
    for (int64_t node = level_size - 1; node > 0; node--) {
        int64_t here = level[node], heavy = weight[here];
        for (int64_t sign = 0; sign < 2; sign++) {
            int64_t above = (rising[here] ? high : low)[node] ^ sign;
            int64_t below = (rising[here] ? low : high)[node] ^ sign;
            for (int64_t room = 0; room < columns; room++)
                if (needed[(2 * node + sign) * columns + room]) {
                    needed[below * columns + room] = 1;
                    if (room >= heavy)
                        needed[above * columns + room - heavy] = 1;
                }
        }
    }
    for (int64_t room = 0; room < columns; room++) {
        family[room] = 1;
        family[columns + room] = 0;
    }
    for (int64_t node = 1; node < level_size; node++) {
        int64_t here = level[node], heavy = weight[here];
        for (int64_t sign = 0; sign < 2; sign++) {
            int64_t above = (rising[here] ? high : low)[node] ^ sign;
            int64_t below = (rising[here] ? low : high)[node] ^ sign;
            for (int64_t room = 0; room < columns; room++) {
                int64_t place = (2 * node + sign) * columns + room;
                if (!needed[place])
                    continue;
                int64_t rest = family[below * columns + room];
                int64_t with = room >= heavy ? family[above * columns + room - heavy] : 0;
                int64_t made = without(&sets, (struct known *)cache, cache_size / 3 - 1,
                                       (struct frame *)frames, with, rest);
                /* Add the element to each set that is left; join them to the sets without it. */
                if (made != OUT_OF_NODES)
                    made = node_of(&sets, here, rest, made);
                if (made == OUT_OF_NODES) {
                    used[0] = (int32_t)sets.count;
                    return OUT_OF_NODES;
                }
                family[place] = (int32_t)made;
            }
        }
    }
    used[0] = (int32_t)sets.count;
    return family[root * columns + most];
}

LOOP int64_t compact(int64_t root, int64_t count, INTEGERS(set_level), INTEGERS(set_low),
                     INTEGERS(set_high), INTEGERS(number))
{
    number[root] = 1;
    for (int64_t node = count - 1; node > 1; node--)
        if (number[node]) {
            number[set_low[node]] = 1;
            number[set_high[node]] = 1;
        }
    number[0] = 0;
    number[1] = 1;
    int64_t kept = 2;
    for (int64_t node = 2; node < count; node++)
        if (number[node]) {
            number[node] = (int32_t)kept;
            set_level[kept] = set_level[node];
            set_low[kept] = number[set_low[node]];
            set_high[kept] = number[set_high[node]];
            kept++;
        }
    return kept;
}

LOOP void totals(INTEGERS(set_level), INTEGERS(set_low), INTEGERS(set_high), FLOATS(value),
                 FLOATS(total))
{
    total[0] = 0.0;
    total[1] = 1.0;
    for (int64_t node = 2; node < set_level_size; node++)
        total[node] = total[set_low[node]] + value[set_level[node]] * total[set_high[node]];
}

LOOP void greatest(INTEGERS(set_level), INTEGERS(set_low), INTEGERS(set_high), FLOATS(value),
                   FLOATS(most))
{
    most[0] = 0.0;
    most[1] = 1.0;
    for (int64_t node = 2; node < set_level_size; node++) {
        double below = most[set_low[node]];
        double above = value[set_level[node]] * most[set_high[node]];
        most[node] = above > below ? above : below;
    }
}

LOOP void lightest(INTEGERS(set_level), INTEGERS(set_low), INTEGERS(set_high), INTEGERS(weight),
                   int64_t none, INTEGERS(least))
{
    least[0] = (int32_t)none;
    least[1] = 0;
    for (int64_t node = 2; node < set_level_size; node++) {
        int32_t above = least[set_high[node]] + weight[set_level[node]];
        int32_t below = least[set_low[node]];
        least[node] = above < below ? above : below;
    }
}
