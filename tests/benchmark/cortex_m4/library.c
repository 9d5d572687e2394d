/* library.c - what one operation of the soft floating point library costs, call included: a loop of OPERATIONS over the
 * outputs of the run, less the same loop without the operation. The cost depends on the operands (how far apart their
 * exponents are, for an addition); those are what the estimators meet.
 */
#include "data.h"
#include "measure.h"

#define OPERATIONS 512U
#define PAIRS 32U
#define INSTRUCTIONS_PER_TICK 40U

/* The optimiser must take its operands for unknown, and its result for used. */
#define LOOP(name, expression)                                                                                         \
    static void name(void)                                                                                             \
    {                                                                                                                  \
        for (uint32_t i = 0; i < OPERATIONS; i++) {                                                                    \
            double a = left[i % PAIRS];                                                                                \
            double b = right[i % PAIRS];                                                                               \
            __asm__ volatile("" : "+r"(a), "+r"(b));                                                                   \
            double result = (expression);                                                                              \
            __asm__ volatile("" : : "r"(result), "r"(b));                                                              \
        }                                                                                                              \
    }

static double left[PAIRS];
static double right[PAIRS];

LOOP(nothing, a)
LOOP(addition, a + b)
LOOP(multiplication, a *b)
LOOP(division, a / b)

static const struct {
    const char *name;
    void (*call)(void);
} cases[] = {{"addition", addition}, {"multiplication", multiplication}, {"division", division}};

static void fill(void)
{
    for (uint32_t i = 0; i < PAIRS; i++) {
        left[i] = benchmark_means.u_v[i % 16U][i % 3U];
        right[i] = benchmark_means.u_v[1U + i % 16U][(i + i / 16U) % 3U];
    }
}

int main(void)
{
    fill();
    const uint32_t empty = measure(nothing).ticks;
    for (uint32_t i = 0; i < (uint32_t)(sizeof cases / sizeof cases[0]); i++) {
        put("library ");
        put(cases[i].name);
        put(" ");
        put_decimal(((measure(cases[i].call).ticks - empty) * INSTRUCTIONS_PER_TICK + OPERATIONS / 2U) / OPERATIONS);
        put("\n");
    }
    return 0;
}
