/* Decision diagrams, compiled: tracerisk/prm/trees/bdd/kernel.py, sweeps.py and thinning.py say what
   each function does, and what its arguments are. */

#include "loops.h"

enum { FIRST_SIZE = 4096, LEAST_SLOTS = 16, STEPS = 8 };

/* ---- nodes, and their unique table ---- */

struct node {
    int32_t level;
    int32_t low;
    int32_t high;
    int32_t number; /* while nodes are dropped: 0 for one that goes, then its new number */
};

struct store {
    struct node *nodes;
    int32_t *table;
    int64_t table_mask;
    int64_t count;
    int64_t size;
};

struct known { /* an entry of the cache of conjunctions; empty where f is 0 */
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

struct work { /* a store with what is computed on it */
    struct store store;
    int64_t budget;
    struct known *cache;
    int64_t cache_mask;
    struct frame *frames;
    int64_t depth;
    int64_t steps_left;
    int32_t *edges;
    int64_t edges_size;
};

static int64_t mask_of(int64_t least)
{
    int64_t size = LEAST_SLOTS;
    while (size < least)
        size *= 2;
    return size - 1;
}

static struct store store_of(int32_t *nodes, int32_t *table, const int32_t *used)
{
    struct store store = {(struct node *)nodes, table, mask_of(used[2] + used[2] / 4), used[0],
                          used[2]};
    return store;
}

static struct work work_of(int32_t *nodes, int64_t nodes_size, int32_t *table, int32_t *cache,
                           const int32_t *used)
{
    struct work work = {store_of(nodes, table, used), nodes_size / 4, (struct known *)cache,
                        mask_of(used[2]), 0, 0, STEPS * (nodes_size / 4), 0, 0};
    return work;
}

static void empty(struct work *work, int64_t levels)
{
    struct known nothing = {0, 0, 0};
    struct node constant = {(int32_t)levels, 0, 0, 0};
    for (int64_t slot = 0; slot <= work->store.table_mask; slot++)
        work->store.table[slot] = 0;
    for (int64_t slot = 0; slot <= work->cache_mask; slot++)
        work->cache[slot] = nothing;
    work->store.nodes[0] = constant;
    work->store.count = 1;
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
    if (store->count >= store->size)
        return OUT_OF_NODES;
    node = store->count++;
    store->table[slot] = (int32_t)node;
    struct node *made = &store->nodes[node];
    made->level = (int32_t)level;
    made->low = (int32_t)low;
    made->high = (int32_t)high;
    return 2 * node + sign;
}

/* ---- collecting ---- */

static void mark(struct node *nodes, int64_t edge)
{
    nodes[edge >> 1].number = 1;
}

static int64_t marked(struct work *work, int64_t held)
{
    struct node *nodes = work->store.nodes;
    int64_t count = work->store.count, live = 1;
    for (int64_t node = 0; node < count; node++)
        nodes[node].number = 0;
    mark(nodes, held);
    for (int64_t place = 0; place < work->edges_size; place++)
        if (work->edges[place] >= 0)
            mark(nodes, work->edges[place]);
    for (int64_t place = 0; place < work->depth; place++) {
        const struct frame *frame = &work->frames[place];
        mark(nodes, frame->f);
        mark(nodes, frame->g);
        if (frame->high >= 0)
            mark(nodes, frame->high);
    }
    for (int64_t node = count - 1; node > 0; node--)
        if (nodes[node].number) {
            mark(nodes, nodes[node].low);
            mark(nodes, nodes[node].high);
            live++;
        }
    return live;
}

static int32_t renumbered(const struct node *nodes, int64_t edge)
{
    return 2 * nodes[edge >> 1].number + (int32_t)(edge & 1);
}

static int is_live(const struct node *nodes, int64_t edge)
{
    return edge < 2 || nodes[edge >> 1].number > 0;
}

/* The entry of each slot moves to that of its new edges; those still to move have f negative. */
static void move_known(struct work *work, int64_t mask)
{
    const struct node *nodes = work->store.nodes;
    struct known *cache = work->cache, nothing = {0, 0, 0};
    for (int64_t slot = 0; slot <= work->cache_mask; slot++) {
        struct known *known = &cache[slot];
        if (known->f == 0)
            continue;
        if (is_live(nodes, known->f) && is_live(nodes, known->g) && is_live(nodes, known->result)) {
            known->f = -renumbered(nodes, known->f);
            known->g = renumbered(nodes, known->g);
            known->result = renumbered(nodes, known->result);
        } else
            *known = nothing;
    }
    for (int64_t slot = work->cache_mask + 1; slot <= mask; slot++)
        cache[slot] = nothing;
    for (int64_t slot = 0; slot <= work->cache_mask; slot++) {
        struct known moving = cache[slot];
        if (moving.f >= 0)
            continue;
        cache[slot] = nothing;
        while (moving.f < 0) {
            moving.f = -moving.f;
            int64_t to = slot_of_pair(moving.f, moving.g, mask);
            struct known before = cache[to];
            cache[to] = moving;
            moving = before;
        }
    }
    work->cache_mask = mask;
}

/* Keep the marked nodes only, in a store of a size; return the new edge for `held`. */
static int64_t compacted(struct work *work, int64_t size, int64_t held)
{
    struct store *store = &work->store;
    struct node *nodes = store->nodes;
    int64_t kept = 1;
    store->size = size;
    store->table_mask = mask_of(size + size / 4);
    for (int64_t slot = 0; slot <= store->table_mask; slot++)
        store->table[slot] = 0;
    nodes[0].number = 0;
    for (int64_t node = 1; node < store->count; node++)
        if (nodes[node].number) {
            int32_t low = renumbered(nodes, nodes[node].low);
            int32_t high = renumbered(nodes, nodes[node].high);
            nodes[node].number = (int32_t)kept;
            struct node *to = &nodes[kept];
            to->level = nodes[node].level;
            to->low = low;
            to->high = high;
            int64_t slot = slot_of_node(to->level, low, high, store->table_mask);
            while (store->table[slot] != 0)
                slot = (slot + 1) & store->table_mask;
            store->table[slot] = (int32_t)kept++;
        }
    for (int64_t place = 0; place < work->edges_size; place++)
        if (work->edges[place] >= 0)
            work->edges[place] = renumbered(nodes, work->edges[place]);
    for (int64_t place = 0; place < work->depth; place++) {
        struct frame *frame = &work->frames[place];
        frame->f = renumbered(nodes, frame->f);
        frame->g = renumbered(nodes, frame->g);
        frame->f_low = renumbered(nodes, frame->f_low);
        frame->g_low = renumbered(nodes, frame->g_low);
        if (frame->high >= 0)
            frame->high = renumbered(nodes, frame->high);
    }
    move_known(work, mask_of(size));
    store->count = kept;
    return renumbered(nodes, held);
}

static int64_t with_room(struct work *work, int64_t held)
{
    int64_t live = marked(work, held), size = work->store.size;
    if (2 * live > size)
        size = 2 * size < work->budget ? 2 * size : work->budget;
    int64_t most = work->steps_left < 0 ? size - 1 : 3 * size / 4;
    if (live > most)
        return OUT_OF_NODES;
    return compacted(work, size, held);
}

/* ---- building ---- */

static int64_t conjunction(struct work *work, int64_t f, int64_t g)
{
    struct store *store = &work->store;
    const struct node *nodes = store->nodes;
    struct known *cache = work->cache;
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
            const struct known *known = &cache[slot_of_pair(f, g, work->cache_mask)];
            if (known->f == f && known->g == g)
                result = known->result;
            else {
                if (!work->steps_left)
                    return OUT_OF_NODES;
                work->steps_left--;
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
                work->frames[work->depth++] = waiting;
                f = f_high;
                g = g_high;
                continue;
            }
        }
        for (;;) {
            if (work->depth == 0)
                return result;
            struct frame *frame = &work->frames[work->depth - 1];
            if (frame->high < 0) {
                frame->high = (int32_t)result;
                f = frame->f_low;
                g = frame->g_low;
                break;
            }
            if (frame->high != result) {
                if (store->count >= store->size)
                    result = with_room(work, result);
                if (result != OUT_OF_NODES)
                    result = edge_of(store, frame->level, result, frame->high);
                if (result == OUT_OF_NODES)
                    return OUT_OF_NODES;
            }
            work->depth--;
            struct known found = {frame->f, frame->g, (int32_t)result};
            cache[slot_of_pair(frame->f, frame->g, work->cache_mask)] = found;
        }
    }
}

LOOP int64_t build(int64_t levels, int64_t first, INTEGERS(offsets), INTEGERS(literals),
                   INTEGERS(last), INTEGERS(edges), INTEGERS(nodes), INTEGERS(table),
                   INTEGERS(cache), INTEGERS(frames), INTEGERS(used))
{
    int64_t budget = nodes_size / 4;
    if (used[2] == 0)
        used[2] = (int32_t)(budget < FIRST_SIZE ? budget : FIRST_SIZE);
    struct work work = work_of(nodes, nodes_size, table, cache, used);
    work.frames = (struct frame *)frames;
    work.edges = edges;
    work.edges_size = edges_size;
    if (last_size == 0)
        work.steps_left = -1; /* no limit */
    if (used[0] == 0)
        empty(&work, levels);
    int64_t joined = 0, place = 0;
    for (int64_t gate = 0; gate + 1 < offsets_size; gate++) {
        joined = 0;
        for (place = offsets[gate]; place < offsets[gate + 1]; place++) {
            int64_t item = literals[place] >> 1, sign = literals[place] & 1;
            if (work.store.count >= work.store.size)
                joined = with_room(&work, joined);
            if (joined == OUT_OF_NODES)
                break;
            int64_t g = item < levels ? edge_of(&work.store, item, 1, 0) : edges[item - levels];
            if (item >= levels && last_size > 0 && last[item - levels] == place)
                edges[item - levels] = -1;
            joined = conjunction(&work, joined, g ^ sign);
            if (joined == OUT_OF_NODES || joined == 1)
                break;
        }
        if (joined == OUT_OF_NODES)
            break;
        edges[first + gate] = (int32_t)joined;
    }
    used[0] = (int32_t)work.store.count;
    used[1] = (int32_t)(joined == OUT_OF_NODES ? place : literals_size);
    used[2] = (int32_t)work.store.size;
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
    struct store store = store_of(nodes, table, used);
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
                  INTEGERS(used))
{
    struct work work = work_of(nodes, nodes_size, table, cache, used);
    work.edges = edges;
    work.edges_size = edges_size;
    marked(&work, 0);
    compacted(&work, work.store.size, 0);
    used[0] = (int32_t)work.store.count;
}
