/* trace.c - which functions of the firmware a sample enters: a run up to a step that takes nothing but the two frames of
 * a sample in the middle of a position. Prints every call of that step: how deep it lies, and the function's address.
 */
#include "navcomp_bench.h"

#include <stdio.h>

#define MOST 4096

typedef struct {
    void *function;
    int depth;
} entered_t;

static entered_t entered[MOST];
static int count;
static int calls; /* of the step */
static int depth;
static uint32_t ordinal;

/* The compiler puts a call of these into every function, of this file and of the bench as well. */
__attribute__((no_instrument_function)) void __cyg_profile_func_enter(void *function, void *caller);
__attribute__((no_instrument_function)) void __cyg_profile_func_exit(void *function, void *caller);

void __cyg_profile_func_enter(void *function, void *caller)
{
    (void)caller;
    if (count < MOST) {
        entered[count++] = (entered_t){function, depth};
    }
    depth++;
}

void __cyg_profile_func_exit(void *function, void *caller)
{
    (void)function;
    (void)caller;
    depth--;
}

static void note_sample(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    (void)context;
    (void)sample;
    ordinal = taken.ordinal;
}

/* As bench_event, without its log; true: the step took a sample and no other frame. The sample is not the first of its
 * position, nor the second, at which the standard error is looked at, nor the last. */
static bool step_takes_a_sample(void)
{
    const size_t frames = bench.fake.to_firmware.count;
    ordinal = 0;
    count = 0;
    depth = 0;
    tumble_navcomp_step(&bench.navcomp);
    calls = count;
    if ((frames == 2U) && (ordinal > 2U) && (ordinal < BENCH_SAMPLES)) {
        return true;
    }
    tumble_can_frame_t frame;
    while (fake_port_take(&bench.fake, &frame)) {
        bench_hear(&bench, &frame);
    }
    bench_play(&bench);
    bench_operate(&bench);
    bench_go_on(&bench, UINT64_MAX);
    return false;
}

int main(void)
{
    bench_begin();
    bench.hooks = (tumble_navcomp_hooks_t){.on_sample_averaged = note_sample};
    bench_start(&bench);
    for (int steps = 0; !step_takes_a_sample(); steps++) {
        TEST_ASSERT_TRUE_MESSAGE(steps < 100000, "no step takes a sample alone");
    }
    TEST_ASSERT_TRUE_MESSAGE(calls < MOST, "more calls than there is room for");
    for (int i = 0; i < calls; i++) {
        printf("%d %p\n", entered[i].depth, entered[i].function);
    }
    return 0;
}
