/* What the compiled loops share: their version, how sequences come, and hash slots.

   A sequence of integers or numbers comes as its address and its length. */

#ifndef TRACERISK_LOOPS_H
#define TRACERISK_LOOPS_H

#include <stdint.h>

#define INTEGERS(name) int32_t *name, int64_t name##_size
#define LONGS(name) int64_t *name, int64_t name##_size
#define BYTES(name) uint8_t *name, int64_t name##_size
#define FLOATS(name) double *name, int64_t name##_size

#if defined(_WIN32)
#define LOOP __declspec(dllexport)
#else
#define LOOP __attribute__((visibility("default")))
#endif

enum { OUT_OF_NODES = -1 };

/* Where a pair, or a triple, is looked for first; the mask is a power of two less one. */
static inline int64_t slot_of_pair(int64_t f, int64_t g, int64_t mask)
{
    int64_t slot = f * 12582917 + g * 4256249;
    return (slot ^ (slot >> 17)) & mask;
}

static inline int64_t slot_of_node(int64_t level, int64_t low, int64_t high, int64_t mask)
{
    int64_t slot = level * 741457 + low * 12582917 + high * 4256249;
    return (slot ^ (slot >> 17)) & mask;
}

#endif
