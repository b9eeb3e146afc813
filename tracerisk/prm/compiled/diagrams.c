/* Decision diagrams, compiled: tracerisk/prm/bdd/kernel.py, sweeps.py and thinning.py say what
   each function does, and what its arguments are. */

#include "loops.h"

/* ---- nodes, and their unique table ---- */

struct node {
    int32_t level;
    int32_t low;
    int32_t high;
    int32_t unused;
};

struct store {
    struct node *nodes;
    int32_t *table;
    int64_t table_mask;
    int64_t count;
    int64_t budget;
};

struct known { /* an entry of the cache of conjunctions */
    int32_t f;
    int32_t g;
    int32_t result;
};

struct frame { /* a conjunction that waits for those below it; high < 0: for the first of two */
    int32_t f;
    int32_t g;
    int32_t level;
    int32_t f_low;
    int32_t g_low;
    int32_t high;
};

static struct store store_of(int32_t *nodes, int64_t nodes_size, int32_t *table, int64_t table_size)
{
    struct store store = {(struct node *)nodes, table, table_size - 1, 0, nodes_size / 4};
    return store;
}

/* The edge of a level and two different edges, or OUT_OF_NODES. */
static int64_t edge_of(struct store *store, int64_t level, int64_t low, int64_t high)
{
    int64_t sign = high & 1;
    low ^= sign;
    high ^= sign;
    int64_t slot = slot_of_node(level, low, high, store->table_mask);
    int64_t node;
    while ((node = store->table[slot]) != 0) {
        const struct node *known = &store->nodes[node];
        if (known->low == low && known->high == high && known->level == level)
            return 2 * node + sign;
        slot = (slot + 1) & store->table_mask;
    }
    if (store->count >= store->budget)
        return OUT_OF_NODES;
    node = store->count++;
    store->table[slot] = (int32_t)node;
    struct node *made = &store->nodes[node];
    made->level = (int32_t)level;
    made->low = (int32_t)low;
    made->high = (int32_t)high;
    return 2 * node + sign;
}

/* ---- building ---- */

static int64_t conjunction(struct store *store, struct known *cache, int64_t cache_mask,
                           struct frame *frames, int64_t f, int64_t g)
{
    const struct node *nodes = store->nodes;
    int64_t depth = 0;
    for (;;) {
        int64_t result;
        if (f == g || g == 0)
            result = f;
        else if (f == 0)
            result = g;
        else if (f == 1 || g == 1 || (f ^ g) == 1)
            result = 1;
        else {
            if (f > g) {
                int64_t other = f;
                f = g;
                g = other;
            }
            const struct known *known = &cache[slot_of_pair(f, g, cache_mask)];
            if (known->f == f && known->g == g)
                result = known->result;
            else {
                const struct node *node_f = &nodes[f >> 1], *node_g = &nodes[g >> 1];
                int32_t level = node_f->level < node_g->level ? node_f->level : node_g->level;
                int64_t f_low = f, f_high = f, g_low = g, g_high = g;
                if (node_f->level == level) {
                    f_low = node_f->low ^ (f & 1);
                    f_high = node_f->high ^ (f & 1);
                }
                if (node_g->level == level) {
                    g_low = node_g->low ^ (g & 1);
                    g_high = node_g->high ^ (g & 1);
                }
                struct frame waiting = {(int32_t)f,     (int32_t)g,     level,
                                        (int32_t)f_low, (int32_t)g_low, -1};
                frames[depth++] = waiting;
                f = f_high;
                g = g_high;
                continue;
            }
        }
        for (;;) {
            if (depth == 0)
                return result;
            struct frame *frame = &frames[depth - 1];
            if (frame->high < 0) {
                frame->high = (int32_t)result;
                f = frame->f_low;
                g = frame->g_low;
                break;
            }
            depth--;
            if (frame->high != result) {
                result = edge_of(store, frame->level, result, frame->high);
                if (result == OUT_OF_NODES)
                    return OUT_OF_NODES;
            }
            struct known found = {frame->f, frame->g, (int32_t)result};
            cache[slot_of_pair(frame->f, frame->g, cache_mask)] = found;
        }
    }
}

LOOP int64_t build(int64_t levels, int64_t first, INTEGERS(offsets), INTEGERS(literals),
                   INTEGERS(edges), INTEGERS(nodes), INTEGERS(table), INTEGERS(cache),
                   INTEGERS(frames), INTEGERS(used))
{
    struct store store = store_of(nodes, nodes_size, table, table_size);
    store.nodes[0].level = (int32_t)levels;
    store.nodes[0].low = 0;
    store.nodes[0].high = 0;
    store.count = used[0] > 1 ? used[0] : 1;
    int64_t joined = 0;
    for (int64_t gate = 0; gate + 1 < offsets_size; gate++) {
        joined = 0;
        for (int64_t place = offsets[gate]; place < offsets[gate + 1]; place++) {
            used[1] = (int32_t)place;
            int64_t item = literals[place] >> 1, sign = literals[place] & 1;
            int64_t g = item < levels ? edge_of(&store, item, 1, 0) : edges[item - levels];
            if (g != OUT_OF_NODES)
                joined = conjunction(&store, (struct known *)cache, cache_size / 3 - 1,
                                     (struct frame *)frames, joined, g ^ sign);
            if (g == OUT_OF_NODES || joined == OUT_OF_NODES) {
                used[0] = (int32_t)store.count;
                return OUT_OF_NODES;
            }
            if (joined == 1)
                break;
        }
        edges[first + gate] = (int32_t)joined;
    }
    used[0] = (int32_t)store.count;
    used[1] = (int32_t)literals_size;
    return joined;
}

LOOP int64_t extract(int64_t root, int64_t count, INTEGERS(nodes), INTEGERS(number),
                     INTEGERS(level), INTEGERS(low), INTEGERS(high))
{
    const struct node *all = (const struct node *)nodes;
    number[root >> 1] = 1;
    for (int64_t node = count - 1; node > 0; node--)
        if (number[node]) {
            number[all[node].low >> 1] = 1;
            number[all[node].high >> 1] = 1;
        }
    number[0] = 0;
    level[0] = all[0].level;
    low[0] = 0;
    high[0] = 0;
    int64_t kept = 1;
    for (int64_t node = 1; node < count; node++)
        if (number[node]) {
            number[node] = (int32_t)kept;
            level[kept] = all[node].level;
            low[kept] = 2 * number[all[node].low >> 1] + (all[node].low & 1);
            high[kept] = 2 * number[all[node].high >> 1];
            kept++;
        }
    return kept;
}

/* ---- what is computed on a finished diagram ---- */

LOOP void sweep(INTEGERS(level), INTEGERS(low), INTEGERS(high), FLOATS(p), FLOATS(q),
                FLOATS(happens), FLOATS(fails))
{
    happens[0] = 1.0;
    fails[0] = 0.0;
    for (int64_t node = 1; node < level_size; node++) {
        double p_here = p[level[node]], q_here = q[level[node]];
        int64_t below = low[node] >> 1, above = high[node] >> 1;
        double low_p = happens[below], low_q = fails[below];
        if (low[node] & 1) {
            low_p = fails[below];
            low_q = happens[below];
        }
        happens[node] = p_here * happens[above] + q_here * low_p;
        fails[node] = p_here * fails[above] + q_here * low_q;
    }
}

LOOP void sweep_many(int64_t samples, INTEGERS(level), INTEGERS(low), INTEGERS(high), FLOATS(p),
                     FLOATS(q), FLOATS(happens), FLOATS(fails))
{
    for (int64_t i = 0; i < samples; i++) {
        happens[i] = 1.0;
        fails[i] = 0.0;
    }
    for (int64_t node = 1; node < level_size; node++) {
        const double *p_here = p + samples * level[node], *q_here = q + samples * level[node];
        int64_t above = samples * (high[node] >> 1), below = samples * (low[node] >> 1);
        const double *low_p = (low[node] & 1 ? fails : happens) + below;
        const double *low_q = (low[node] & 1 ? happens : fails) + below;
        double *happens_here = happens + samples * node, *fails_here = fails + samples * node;
        for (int64_t i = 0; i < samples; i++) {
            happens_here[i] = p_here[i] * happens[above + i] + q_here[i] * low_p[i];
            fails_here[i] = p_here[i] * fails[above + i] + q_here[i] * low_q[i];
        }
    }
}

struct pair { /* a difference of two edges that waits for those below it */
    int32_t f;
    int32_t g;
    int32_t sign;
    int32_t is_second;
    int32_t level;
};

static const double EXACT_ENOUGH = 16.0;

static double magnitude(double value)
{
    return value < 0.0 ? -value : value;
}

LOOP int64_t edge_gains(INTEGERS(level), INTEGERS(low), INTEGERS(high), FLOATS(p), FLOATS(q),
                        FLOATS(happens), FLOATS(fails), INTEGERS(wanted), FLOATS(gains),
                        INTEGERS(memo_f), INTEGERS(memo_g), FLOATS(memo_gain), INTEGERS(frames),
                        FLOATS(partial))
{
    struct pair *stack = (struct pair *)frames;
    int64_t mask = memo_f_size - 1, most = memo_f_size - memo_f_size / 4, pairs = 0;
    int is_full = 0;
    for (int64_t start = 1; start < level_size; start++) {
        if (!wanted[level[start]])
            continue;
        int64_t f = high[start], g = low[start], depth = 0;
        double result = 0.0;
        for (;;) {
            int is_found = 1;
            if (f == g)
                result = 0.0;
            else {
                int64_t node_f = f >> 1, node_g = g >> 1;
                double p_f = f & 1 ? fails[node_f] : happens[node_f];
                double q_f = f & 1 ? happens[node_f] : fails[node_f];
                double p_g = g & 1 ? fails[node_g] : happens[node_g];
                double q_g = g & 1 ? happens[node_g] : fails[node_g];
                double scale_p = p_f < p_g ? p_g : p_f, scale_q = q_f < q_g ? q_g : q_f;
                double scale = scale_q;
                if (scale_p <= scale_q) {
                    result = p_f - p_g;
                    scale = scale_p;
                } else
                    result = q_g - q_f;
                if (magnitude(result) * EXACT_ENOUGH < scale && !is_full) {
                    int32_t sign = 0;
                    if (node_f < node_g) {
                        int64_t other = f;
                        f = g;
                        g = other;
                        sign = 1;
                    }
                    if (f & 1) {
                        f ^= 1;
                        g ^= 1;
                        sign ^= 1;
                    }
                    int64_t slot = slot_of_pair(f, g, mask);
                    while (memo_f[slot] != 0 && (memo_f[slot] != f || memo_g[slot] != g))
                        slot = (slot + 1) & mask;
                    if (memo_f[slot] != 0)
                        result = sign ? -memo_gain[slot] : memo_gain[slot];
                    else {
                        is_found = 0;
                        node_f = f >> 1;
                        node_g = g >> 1;
                        int32_t top =
                            level[node_g] < level[node_f] ? level[node_g] : level[node_f];
                        struct pair waiting = {(int32_t)f, (int32_t)g, sign, 0, top};
                        stack[depth++] = waiting;
                        if (level[node_g] == top)
                            g = high[node_g] ^ (g & 1);
                        if (level[node_f] == top)
                            f = high[node_f];
                    }
                }
            }
            if (!is_found)
                continue;
            while (depth > 0) {
                struct pair *waiting = &stack[depth - 1];
                f = waiting->f;
                g = waiting->g;
                int32_t top = waiting->level;
                if (!waiting->is_second) {
                    waiting->is_second = 1;
                    partial[depth - 1] = p[top] * result;
                    if (level[g >> 1] == top)
                        g = low[g >> 1] ^ (g & 1);
                    if (level[f >> 1] == top)
                        f = low[f >> 1];
                    break;
                }
                depth--;
                result = partial[depth] + q[top] * result;
                if (pairs < most) {
                    int64_t slot = slot_of_pair(f, g, mask);
                    while (memo_f[slot] != 0)
                        slot = (slot + 1) & mask;
                    memo_f[slot] = (int32_t)f;
                    memo_g[slot] = (int32_t)g;
                    memo_gain[slot] = result;
                    pairs++;
                } else
                    is_full = 1;
                if (waiting->sign)
                    result = -result;
            }
            if (depth == 0)
                break;
        }
        gains[start] = result;
    }
    return is_full ? -1 : pairs;
}

LOOP void derivatives(int64_t root, INTEGERS(level), INTEGERS(low), INTEGERS(high), FLOATS(p),
                      FLOATS(q), FLOATS(gains), FLOATS(reach), FLOATS(out))
{
    reach[root >> 1] = root & 1 ? -1.0 : 1.0;
    for (int64_t node = level_size - 1; node > 0; node--) {
        double weight = reach[node];
        int32_t here = level[node];
        out[here] += weight * gains[node];
        reach[high[node] >> 1] += weight * p[here];
        if (low[node] & 1)
            reach[low[node] >> 1] -= weight * q[here];
        else
            reach[low[node] >> 1] += weight * q[here];
    }
}

LOOP void differences(INTEGERS(level), INTEGERS(low), INTEGERS(high), FLOATS(p), FLOATS(q),
                      FLOATS(drop), FLOATS(gains), FLOATS(out))
{
    out[0] = 0.0;
    for (int64_t node = 1; node < level_size; node++) {
        int32_t here = level[node];
        double below = out[low[node] >> 1];
        if (low[node] & 1)
            below = -below;
        out[node] = p[here] * out[high[node] >> 1] + q[here] * below + drop[here] * gains[node];
    }
}

/* ---- diagrams of bounded size ---- */

LOOP int64_t thinned(int64_t edge, int64_t most, INTEGERS(nodes), INTEGERS(table), FLOATS(p),
                     FLOATS(q), FLOATS(happens), FLOATS(fails), FLOATS(reach), INTEGERS(under),
                     INTEGERS(used))
{
    struct store store = store_of(nodes, nodes_size, table, table_size);
    store.count = used[0];
    const struct node *all = store.nodes;
    int64_t root = edge >> 1;
    happens[0] = 1.0;
    fails[0] = 0.0;
    for (int64_t node = 1; node <= root; node++) {
        int32_t here = all[node].level;
        int64_t below = all[node].low >> 1, above = all[node].high >> 1;
        double low_p = happens[below], low_q = fails[below];
        if (all[node].low & 1) {
            low_p = fails[below];
            low_q = happens[below];
        }
        happens[node] = p[here] * happens[above] + q[here] * low_p;
        fails[node] = p[here] * fails[above] + q[here] * low_q;
    }
    double whole = edge & 1 ? fails[root] : happens[root], least = 0.0;
    for (;;) {
        int64_t kept = 0;
        for (int64_t half = 0; half < 2 * root + 2; half++)
            reach[half] = 0.0;
        reach[edge] = 1.0;
        for (int64_t node = root; node > 0; node--) {
            int32_t here = all[node].level;
            for (int64_t sign = 0; sign < 2; sign++) {
                double weight = reach[2 * node + sign];
                if (!(weight > 0.0))
                    continue;
                if (weight * (sign ? fails[node] : happens[node]) <= least) {
                    reach[2 * node + sign] = -1.0;
                    continue;
                }
                kept++;
                int64_t high = all[node].high ^ sign, low = all[node].low ^ sign;
                if (reach[high] >= 0.0)
                    reach[high] += weight * p[here];
                if (reach[low] >= 0.0)
                    reach[low] += weight * q[here];
            }
        }
        if (kept <= most)
            break;
        least = least > 0.0 ? 4.0 * least : whole * 1e-12;
    }
    if (least == 0.0)
        return edge;
    under[0] = 0;
    under[1] = 1;
    for (int64_t node = 1; node <= root; node++)
        for (int64_t sign = 0; sign < 2; sign++) {
            int64_t half = 2 * node + sign;
            under[half] = 1;
            if (!(reach[half] > 0.0))
                continue;
            int64_t low = under[all[node].low ^ sign], high = under[all[node].high ^ sign];
            int64_t made = low == high ? low : edge_of(&store, all[node].level, low, high);
            if (made == OUT_OF_NODES)
                return OUT_OF_NODES;
            under[half] = (int32_t)made;
        }
    used[0] = (int32_t)store.count;
    return under[edge];
}

LOOP void collect(INTEGERS(edges), INTEGERS(nodes), INTEGERS(table), INTEGERS(cache),
                  INTEGERS(number), INTEGERS(used))
{
    struct node *all = (struct node *)nodes;
    int64_t count = used[0], mask = table_size - 1, kept = 1;
    for (int64_t slot = 0; slot < table_size; slot++)
        table[slot] = 0;
    for (int64_t slot = 0; slot < cache_size; slot++)
        cache[slot] = 0;
    for (int64_t node = 0; node < count; node++)
        number[node] = 0;
    for (int64_t place = 0; place < edges_size; place++)
        if (edges[place] >= 0)
            number[edges[place] >> 1] = 1;
    for (int64_t node = count - 1; node > 0; node--)
        if (number[node]) {
            number[all[node].low >> 1] = 1;
            number[all[node].high >> 1] = 1;
        }
    number[0] = 0;
    for (int64_t node = 1; node < count; node++)
        if (number[node]) {
            number[node] = (int32_t)kept;
            struct node *to = &all[kept];
            to->level = all[node].level;
            to->low = 2 * number[all[node].low >> 1] + (all[node].low & 1);
            to->high = 2 * number[all[node].high >> 1];
            int64_t slot = slot_of_node(to->level, to->low, to->high, mask);
            while (table[slot] != 0)
                slot = (slot + 1) & mask;
            table[slot] = (int32_t)kept++;
        }
    for (int64_t place = 0; place < edges_size; place++)
        if (edges[place] >= 0)
            edges[place] = 2 * number[edges[place] >> 1] + (edges[place] & 1);
    used[0] = (int32_t)kept;
}
