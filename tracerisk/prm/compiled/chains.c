/* Elimination of large chains: tracerisk/prm/other_models/markov/large/ says what each function does, and what
   its arguments are. Nothing is allocated here; scratch comes from the caller. */

#include "loops.h"

/* A sum whose rounding errors are added up beside it: Neumaier 1974. */
struct sum {
    double total;
    double lost;
};

static inline void add(struct sum *sum, double added)
{
    double grown = sum->total + added;
    if (sum->total >= added)
        sum->lost += (sum->total - grown) + added;
    else
        sum->lost += (added - grown) + sum->total;
    sum->total = grown;
}

/* ---- patterns of matrices in compressed rows ---- */

LOOP void transposed(LONGS(indptr), INTEGERS(indices), FLOATS(data), LONGS(starts),
                     LONGS(next_slot), INTEGERS(rows), FLOATS(values))
{
    int64_t n = indptr_size - 1;
    for (int64_t t = 0; t < indices_size; t++)
        starts[indices[t] + 1]++;
    for (int64_t i = 0; i < n; i++)
        starts[i + 1] += starts[i];
    for (int64_t i = 0; i < n; i++)
        next_slot[i] = starts[i];
    for (int64_t i = 0; i < n; i++)
        for (int64_t t = indptr[i]; t < indptr[i + 1]; t++) {
            int64_t place = next_slot[indices[t]]++;
            rows[place] = (int32_t)i;
            values[place] = data[t];
        }
}

LOOP int64_t neighbours(LONGS(indptr), INTEGERS(indices), LONGS(turned_ptr), INTEGERS(turned),
                        INTEGERS(seen), LONGS(starts), INTEGERS(found))
{
    int64_t count = 0;
    for (int32_t i = 0; i < indptr_size - 1; i++) {
        seen[i] = i;
        for (int64_t t = indptr[i]; t < indptr[i + 1]; t++) {
            int32_t j = indices[t];
            if (seen[j] != i) {
                seen[j] = i;
                found[count++] = j;
            }
        }
        for (int64_t t = turned_ptr[i]; t < turned_ptr[i + 1]; t++) {
            int32_t j = turned[t];
            if (seen[j] != i) {
                seen[j] = i;
                found[count++] = j;
            }
        }
        starts[i + 1] = count;
    }
    return count;
}

LOOP void reach_backwards(LONGS(turned_ptr), INTEGERS(turned), BYTES(reached), INTEGERS(waiting))
{
    int64_t count = 0;
    for (int64_t i = 0; i < reached_size; i++)
        if (reached[i])
            waiting[count++] = (int32_t)i;
    while (count) {
        int32_t i = waiting[--count];
        for (int64_t t = turned_ptr[i]; t < turned_ptr[i + 1]; t++) {
            int32_t j = turned[t];
            if (!reached[j]) {
                reached[j] = 1;
                waiting[count++] = j;
            }
        }
    }
}

/* ---- error-free sums and products of two doubles: Dekker 1971, Knuth 4.2.2 ---- */

struct pair {
    double high;
    double low;
};

static inline struct pair exact_sum(double a, double b)
{
    double total = a + b, part = total - a;
    struct pair found = {total, (a - (total - part)) + (b - part)};
    return found;
}

static inline struct pair exact_product(double a, double b)
{
    const double splitter = 134217729.0; /* 2^27 + 1 */
    double product = a * b;
    double scaled = splitter * a, a_high = scaled - (scaled - a), a_low = a - a_high;
    scaled = splitter * b;
    double b_high = scaled - (scaled - b), b_low = b - b_high;
    struct pair found = {product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) +
                                      a_low * b_low};
    return found;
}

static inline double magnitude(double value)
{
    return value < 0.0 ? -value : value;
}

LOOP int64_t split(LONGS(indptr), INTEGERS(indices), FLOATS(data), BYTES(absorbing),
                   INTEGERS(place), LONGS(transient), LONGS(starts), INTEGERS(targets),
                   FLOATS(values), FLOATS(slack), FLOATS(slack_low), INTEGERS(ends),
                   FLOATS(totals))
{
    int64_t count = 0;
    for (int64_t k = 0; k < transient_size; k++) {
        int64_t i = transient[k];
        struct sum row = {0.0, 0.0};
        struct pair leaving = {0.0, 0.0};
        for (int64_t t = indptr[i]; t < indptr[i + 1]; t++) {
            double weight = data[t];
            if (weight == 0.0)
                continue;
            add(&row, weight);
            int32_t j = indices[t];
            if (absorbing[j]) {
                struct pair sum = exact_sum(leaving.high, weight);
                leaving = exact_sum(sum.high, leaving.low + sum.low);
                ends[k]++;
            } else if (j != i) {
                targets[count] = place[j];
                values[count++] = weight;
            }
        }
        starts[k + 1] = count;
        slack[k] = leaving.high;
        slack_low[k] = leaving.low;
        totals[k] = row.total + row.lost;
    }
    return count;
}

LOOP void gathered(LONGS(indptr), INTEGERS(indices), FLOATS(data), BYTES(chosen),
                   LONGS(transient), FLOATS(stay), FLOATS(total), FLOATS(lost))
{
    for (int64_t k = 0; k < transient_size; k++) {
        int64_t i = transient[k];
        for (int64_t t = indptr[i]; t < indptr[i + 1]; t++) {
            int32_t j = indices[t];
            if (chosen[j]) {
                struct sum sum = {total[j], lost[j]};
                add(&sum, stay[k] * data[t]);
                total[j] = sum.total;
                lost[j] = sum.lost;
            }
        }
    }
}

LOOP void row_sums_into(LONGS(indptr), INTEGERS(indices), FLOATS(data), BYTES(chosen),
                        LONGS(transient), FLOATS(sums), FLOATS(low))
{
    for (int64_t k = 0; k < transient_size; k++) {
        int64_t i = transient[k];
        struct pair total = {0.0, 0.0};
        for (int64_t t = indptr[i]; t < indptr[i + 1]; t++)
            if (chosen[indices[t]]) {
                struct pair sum = exact_sum(total.high, data[t]);
                total = exact_sum(sum.high, total.low + sum.low);
            }
        sums[k] = total.high;
        low[k] = total.low;
    }
}

/* ---- fill-in of the elimination ---- */

LOOP void elimination_tree(INTEGERS(order), INTEGERS(rank), LONGS(indptr), INTEGERS(indices),
                           INTEGERS(parent), INTEGERS(ancestor))
{
    for (int32_t k = 0; k < order_size; k++) {
        int32_t i = order[k];
        for (int64_t t = indptr[i]; t < indptr[i + 1]; t++) {
            int32_t j = rank[indices[t]];
            while (j != -1 && j < k) {
                int32_t following = ancestor[j];
                ancestor[j] = k;
                if (following == -1)
                    parent[j] = k;
                j = following;
            }
        }
    }
}

LOOP void depth_first(int64_t head, INTEGERS(order), INTEGERS(parent), INTEGERS(child),
                      INTEGERS(sibling), INTEGERS(stack), INTEGERS(result))
{
    for (int64_t k = head - 1; k >= 0; k--) {
        int32_t above = parent[k];
        if (above != -1 && above < head) {
            sibling[k] = child[above];
            child[above] = (int32_t)k;
        }
    }
    int64_t placed = 0;
    for (int64_t root = 0; root < head; root++) {
        if (parent[root] != -1 && parent[root] < head)
            continue;
        int64_t depth = 1;
        stack[0] = (int32_t)root;
        while (depth) {
            int32_t k = stack[depth - 1], below = child[k];
            if (below != -1) {
                child[k] = sibling[below];
                stack[depth++] = below;
            } else {
                depth--;
                result[placed++] = order[k];
            }
        }
    }
}

LOOP void count_fill(int64_t head, INTEGERS(order), INTEGERS(rank), LONGS(indptr),
                     INTEGERS(indices), INTEGERS(parent), INTEGERS(mark), LONGS(into), LONGS(out))
{
    for (int32_t k = 0; k < order_size; k++) {
        mark[k] = k;
        int32_t i = order[k];
        for (int64_t t = indptr[i]; t < indptr[i + 1]; t++)
            for (int32_t j = rank[indices[t]]; j != -1 && j < k && j < head && mark[j] != k;
                 j = parent[j]) {
                mark[j] = k;
                into[k + 1]++;
                out[j + 1]++;
            }
    }
}

LOOP void later_states(int64_t head, INTEGERS(order), INTEGERS(rank), LONGS(indptr),
                       INTEGERS(indices), INTEGERS(parent), INTEGERS(mark), LONGS(free),
                       INTEGERS(found))
{
    for (int32_t k = 0; k < order_size; k++) {
        mark[k] = k;
        int32_t i = order[k];
        for (int64_t t = indptr[i]; t < indptr[i + 1]; t++)
            for (int32_t j = rank[indices[t]]; j != -1 && j < k && j < head && mark[j] != k;
                 j = parent[j]) {
                mark[j] = k;
                found[free[j]++] = k;
            }
    }
}

/* ---- elimination: Grassmann, Taksar, Heyman 1985 ---- */

/* Whether the state before k leads to k and otherwise to exactly the states that k leads to. */
static int follows(const int32_t *out_state, const int64_t *out_ptr, const int64_t *out_end,
                   int64_t k)
{
    int64_t before = out_ptr[k - 1], count = out_end[k] - out_ptr[k];
    if (out_end[k - 1] - before != count + 1 || out_state[before] != k)
        return 0;
    int64_t same = 0;
    while (same < count && out_state[before + 1 + same] == out_state[out_ptr[k] + same])
        same++;
    return same == count;
}

LOOP int64_t eliminate_rows(int64_t head, INTEGERS(order), INTEGERS(rank), INTEGERS(parent),
                            LONGS(indptr), INTEGERS(indices), FLOATS(data), FLOATS(slack),
                            LONGS(in_ptr), LONGS(in_end), INTEGERS(in_state), FLOATS(in_weight),
                            LONGS(out_ptr), LONGS(out_end), INTEGERS(out_state),
                            FLOATS(out_share), FLOATS(leaving), FLOATS(dense), FLOATS(slack_share),
                            BYTES(paired), FLOATS(row), INTEGERS(mark), INTEGERS(stack),
                            INTEGERS(path), double smallest)
{
    int64_t n = order_size, rest = n - head;
    for (int32_t k = 0; k < n; k++) {
        int32_t i = order[k];
        mark[k] = k;
        int64_t top = n;
        /* The states eliminated earlier that this row leads to, in topological order. */
        for (int64_t t = indptr[i]; t < indptr[i + 1]; t++) {
            int32_t j = rank[indices[t]];
            row[j] = data[t];
            int64_t steps = 0;
            while (j != -1 && j < k && j < head && mark[j] != k) {
                mark[j] = k;
                path[steps++] = j;
                j = parent[j];
            }
            while (steps)
                stack[--top] = path[--steps];
        }
        struct sum out = {slack[i], 0.0};
        int64_t filled = in_ptr[k];
        for (int64_t t = top; t < n;) {
            int32_t j = stack[t++];
            double weight = row[j];
            row[j] = 0.0;
            if (weight == 0.0)
                continue;
            in_state[filled] = j;
            in_weight[filled++] = weight;
            double added = weight * slack_share[j];
            if (paired[j] && t < n && stack[t] == j + 1) {
                /* Apart from j -> j+1, both lead to the same states, so one pass serves both. */
                t++;
                int64_t first = out_ptr[j];
                double second = row[j + 1] + weight * out_share[first];
                row[j + 1] = 0.0;
                in_state[filled] = j + 1;
                in_weight[filled++] = second;
                int64_t shift = out_ptr[j + 1] - first - 1;
                for (int64_t s = first + 1; s < out_end[j]; s++)
                    row[out_state[s]] += weight * out_share[s] + second * out_share[s + shift];
                added += second * slack_share[j + 1];
            } else
                for (int64_t s = out_ptr[j]; s < out_end[j]; s++)
                    row[out_state[s]] += weight * out_share[s];
            add(&out, added);
        }
        in_end[k] = filled;
        double out_slack = out.total + out.lost;
        if (k >= head) {
            /* The way back to oneself stands on the diagonal, and is never read. */
            double *here = dense + (k - head) * (rest + 1);
            for (int64_t j = head; j < n; j++) {
                here[j - head] = row[j];
                row[j] = 0.0;
            }
            here[rest] = out_slack;
            continue;
        }
        row[k] = 0.0;
        int64_t put = out_ptr[k];
        for (int64_t t = out_ptr[k]; t < out_ptr[k + 1]; t++) {
            int32_t j = out_state[t];
            double weight = row[j];
            if (weight == 0.0)
                continue;
            row[j] = 0.0;
            out_state[put] = j;
            out_share[put++] = weight;
            add(&out, weight);
        }
        out_end[k] = put;
        double total = out.total + out.lost;
        if (!(total >= smallest))
            return i;
        leaving[k] = total;
        slack_share[k] = out_slack / total;
        for (int64_t t = out_ptr[k]; t < put; t++)
            out_share[t] /= total;
        if (k > 0)
            paired[k - 1] = (uint8_t)follows(out_state, out_ptr, out_end, k);
    }
    return -1;
}

LOOP int64_t eliminate_block(int64_t size, int64_t first, int64_t last, FLOATS(dense),
                             FLOATS(leaving), double smallest)
{
    int64_t width = size + 1;
    for (int64_t k = first; k < last; k++) {
        double *from = dense + k * width;
        struct sum out = {0.0, 0.0};
        for (int64_t j = k + 1; j <= size; j++)
            add(&out, from[j]);
        double total = out.total + out.lost;
        if (!(total >= smallest))
            return k;
        leaving[k] = total;
        for (int64_t j = k + 1; j <= size; j++)
            from[j] /= total;
        for (int64_t i = k + 1; i < last; i++) {
            double *to = dense + i * width, weight = to[k];
            if (weight != 0.0)
                for (int64_t j = k + 1; j <= size; j++)
                    to[j] += weight * from[j];
        }
    }
    for (int64_t i = last; i < size; i++)
        for (int64_t k = first; k < last; k++) {
            double *to = dense + i * width, weight = to[k];
            const double *from = dense + k * width;
            if (weight != 0.0)
                for (int64_t j = k + 1; j < last; j++)
                    to[j] += weight * from[j];
        }
    return -1;
}

LOOP void solve_left(int64_t head, FLOATS(moved), FLOATS(leaving), LONGS(in_ptr), LONGS(in_end),
                     INTEGERS(in_state), FLOATS(in_weight), LONGS(out_ptr), LONGS(out_end),
                     INTEGERS(out_state), FLOATS(out_share), FLOATS(dense))
{
    int64_t n = leaving_size, width = n - head + 1;
    for (int64_t k = 0; k < head; k++) {
        double mass = moved[k];
        if (mass != 0.0)
            for (int64_t t = out_ptr[k]; t < out_end[k]; t++)
                moved[out_state[t]] += mass * out_share[t];
    }
    for (int64_t k = head; k < n; k++) {
        double mass = moved[k];
        if (mass != 0.0)
            for (int64_t j = k + 1; j < n; j++)
                moved[j] += mass * dense[(k - head) * width + j - head];
    }
    for (int64_t k = n - 1; k >= 0; k--) {
        double value = moved[k] / leaving[k];
        moved[k] = value;
        if (value == 0.0)
            continue;
        if (k >= head)
            for (int64_t j = head; j < k; j++)
                moved[j] += value * dense[(k - head) * width + j - head];
        for (int64_t t = in_ptr[k]; t < in_end[k]; t++)
            moved[in_state[t]] += value * in_weight[t];
    }
}

LOOP void solve_right(int64_t head, FLOATS(value), FLOATS(leaving), LONGS(in_ptr), LONGS(in_end),
                      INTEGERS(in_state), FLOATS(in_weight), LONGS(out_ptr), LONGS(out_end),
                      INTEGERS(out_state), FLOATS(out_share), FLOATS(dense))
{
    int64_t n = leaving_size, width = n - head + 1;
    for (int64_t k = 0; k < n; k++) {
        struct sum sum = {value[k], 0.0};
        for (int64_t t = in_ptr[k]; t < in_end[k]; t++)
            add(&sum, in_weight[t] * value[in_state[t]]);
        if (k >= head)
            for (int64_t j = head; j < k; j++)
                sum.total += dense[(k - head) * width + j - head] * value[j];
        value[k] = (sum.total + sum.lost) / leaving[k];
    }
    for (int64_t k = n - 1; k >= 0; k--) {
        struct sum sum = {value[k], 0.0};
        if (k >= head)
            for (int64_t j = k + 1; j < n; j++)
                sum.total += dense[(k - head) * width + j - head] * value[j];
        else {
            for (int64_t t = out_ptr[k]; t < out_end[k]; t++)
                add(&sum, out_share[t] * value[out_state[t]]);
            sum.total += sum.lost;
        }
        value[k] = sum.total;
    }
}

/* ---- what a solution leaves unexplained, in twice the working precision ---- */

LOOP void right_residual(LONGS(indptr), INTEGERS(indices), FLOATS(data), FLOATS(slack),
                         FLOATS(slack_low), FLOATS(reward), FLOATS(reward_low), FLOATS(high),
                         FLOATS(low), FLOATS(residual), FLOATS(size))
{
    for (int64_t i = 0; i < slack_size; i++) {
        double value = high[i], rest = low[i];
        struct pair product = exact_product(slack[i], value);
        struct pair total = exact_sum(reward[i], -product.high);
        double error = total.low;
        error += reward_low[i] - (product.low + slack[i] * rest + slack_low[i] * value);
        double sizes = magnitude(reward[i]) + product.high;
        for (int64_t t = indptr[i]; t < indptr[i + 1]; t++) {
            int32_t j = indices[t];
            struct pair difference = exact_sum(high[j], -value);
            double left = difference.low;
            left += low[j] - rest;
            product = exact_product(data[t], difference.high);
            total = exact_sum(total.high, product.high);
            error += total.low + (product.low + data[t] * left);
            sizes += magnitude(product.high) + data[t] * (magnitude(low[j]) + magnitude(rest));
        }
        residual[i] = total.high + error;
        size[i] = sizes;
    }
}

LOOP void left_residual(LONGS(indptr), INTEGERS(indices), FLOATS(data), FLOATS(slack),
                        FLOATS(slack_low), FLOATS(high), FLOATS(low), FLOATS(total),
                        FLOATS(error), FLOATS(size))
{
    for (int64_t i = 0; i < slack_size; i++) {
        double value = high[i], rest = low[i], lost_leaving = slack_low[i];
        struct pair leaving = {slack[i], 0.0}, product, sum;
        for (int64_t t = indptr[i]; t < indptr[i + 1]; t++) {
            int32_t j = indices[t];
            leaving = exact_sum(leaving.high, data[t]);
            lost_leaving += leaving.low;
            product = exact_product(value, data[t]);
            sum = exact_sum(total[j], product.high);
            total[j] = sum.high;
            error[j] += sum.low + (product.low + rest * data[t]);
            size[j] += magnitude(product.high);
        }
        product = exact_product(value, leaving.high);
        sum = exact_sum(total[i], -product.high);
        total[i] = sum.high;
        error[i] += sum.low - (product.low + value * lost_leaving + rest * leaving.high);
        size[i] += magnitude(product.high);
    }
}

LOOP void leaving_and_terms(LONGS(indptr), INTEGERS(indices), FLOATS(data), INTEGERS(ends),
                            FLOATS(leaving), FLOATS(right), FLOATS(left))
{
    for (int64_t i = 0; i < leaving_size; i++) {
        double total = leaving[i];
        for (int64_t t = indptr[i]; t < indptr[i + 1]; t++) {
            total += data[t];
            left[indices[t]] += 1.0;
        }
        leaving[i] = total;
        right[i] = (double)(indptr[i + 1] - indptr[i] + ends[i]) + 4.0;
        left[i] += right[i];
    }
}
