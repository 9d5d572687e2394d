/* navcomp_steps.c - a whole calibration on the target, the bus and the stand played beside it: what each step of the navigation
 * computer takes. The port that is played belongs to a step; the drive and the block that are played do not.
 */
#include "measure.h"
#include "navcomp_bench.h"

#define SECONDS 3000U

typedef struct {
    const char *name;
    uint32_t steps;
    uint64_t ticks;
    uint32_t least_ticks;
    uint32_t most_ticks;
    tumble_state_t at; /* the state after the longest */
} kind_t;

enum { IDLE, SAMPLE, OTHER, KINDS };

static bool averaged;
static uint32_t stack_bytes;
static kind_t kinds[KINDS] = {{.name = "idle"}, {.name = "sample"}, {.name = "other"}};

static void note_sample(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample)
{
    (void)context;
    (void)taken;
    (void)sample;
    averaged = true;
}

static void step(void)
{
    tumble_navcomp_step(&bench.navcomp);
}

static void measure_step(void)
{
    const bool received = (bench.fake.to_firmware.count != 0U);
    averaged = false;
    const taken_t taken = measure(step);
    const bool sent = (bench.fake.from_firmware.count != 0U);
    kind_t *kind = &kinds[averaged ? SAMPLE : (received || sent) ? OTHER : IDLE];
    if ((kind->steps == 0U) || (taken.ticks < kind->least_ticks)) {
        kind->least_ticks = taken.ticks;
    }
    kind->steps++;
    kind->ticks += taken.ticks;
    if (taken.ticks > kind->most_ticks) {
        kind->most_ticks = taken.ticks;
        kind->at = bench_progress(&bench).run.state;
    }
    stack_bytes = (taken.stack_bytes > stack_bytes) ? taken.stack_bytes : stack_bytes;
}

/* As bench_event, without its log of what was received. */
static void event(void)
{
    tumble_can_frame_t frame = {0};
    measure_step();
    while (fake_port_take(&bench.fake, &frame)) {
        bench_hear(&bench, &frame);
    }
    bench_play(&bench);
    bench_operate(&bench);
    bench_go_on(&bench, UINT64_MAX);
}

/* Name, how many, then instructions: mean, least, most, and the state after the longest. */
static void tell(const kind_t *kind)
{
    put("step ");
    put(kind->name);
    put(" ");
    put_decimal(kind->steps);
    put(" ");
    put_decimal((uint32_t)((kind->ticks * 40U) / ((kind->steps == 0U) ? 1U : kind->steps)));
    put(" ");
    put_decimal(kind->least_ticks * 40U);
    put(" ");
    put_decimal(kind->most_ticks * 40U);
    put(" ");
    put(tumble_state_name(kind->at));
    put("\n");
}

void setUp(void) {}

void tearDown(void) {}

int main(void)
{
    bench_init(&bench);
    bench.hooks = (tumble_navcomp_hooks_t){.on_sample_averaged = note_sample};
    bench_start(&bench);
    tumble_state_t state = bench_progress(&bench).run.state;
    while ((state != TUMBLE_STATE_DONE) && (state != TUMBLE_STATE_FAULT) && (state != TUMBLE_STATE_ABORT) &&
           (bench.fake.now_us < SECONDS * UINT64_C(1000000))) {
        event();
        state = bench_progress(&bench).run.state;
    }
    put("ended ");
    put(tumble_state_name(state));
    put("\nstack navcomp_step ");
    put_decimal(stack_bytes);
    put("\n");
    for (int kind = 0; kind < KINDS; kind++) {
        tell(&kinds[kind]);
    }
    return (state == TUMBLE_STATE_DONE) ? 0 : 1;
}
