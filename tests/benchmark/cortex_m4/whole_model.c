/* whole_model.c - the test of the whole model in steps, on the target: for every schedule how many steps it takes, the
 * instructions of all and of the longest, and its stack. The stand declares every error, so that no row has a zero.
 */
#include "data.h"
#include "measure.h"
#include "tumble/core.h"

#include <stddef.h>
#include <stdint.h>

#define SAMPLES 50U
#define V_PER_COUNT 1e-6
#define INSTRUCTIONS_PER_TICK 40U

static const struct {
    const char *name;
    const tumble_schedule_t *schedule;
    const tumble_means_t *means;
} cases[] = {
    {"paper", &tumble_schedule_paper, &benchmark_means},
    {"three_mountings", &tumble_schedule_three_mountings, &benchmark_three_mountings},
    {"diagonal", &tumble_schedule_diagonal, &benchmark_diagonal},
};

static tumble_averaging_t averaging;
static tumble_stand_record_t stand;
static tumble_coefficients_t coefficients;
static tumble_misfit_run_t run;
static tumble_whole_work_t work;
static bool more;

static void fill(const tumble_schedule_t *schedule, const tumble_means_t *means)
{
    for (uint8_t p = 0; p < schedule->position_count; p++) {
        tumble_average_t *average = &averaging.averages[p];
        *average = (tumble_average_t){.samples = SAMPLES};
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            average->sum_counts[i] = (int64_t)((means->u_v[p][i] * (double)SAMPLES) / V_PER_COUNT);
        }
    }
}

static void step(void)
{
    more = tumble_whole_step(&work, &run);
}

static void put_number(uint32_t number)
{
    put(" ");
    put_decimal(number);
}

static void test(const char *name, const tumble_schedule_t *schedule, const tumble_means_t *means)
{
    uint32_t steps = 0;
    uint64_t ticks = 0;
    taken_t most = {0, 0};
    fill(schedule, means);
    (void)tumble_estimate_least_squares(schedule, means, &coefficients, NULL);
    run = (tumble_misfit_run_t){schedule, &averaging, &coefficients, &stand, V_PER_COUNT};
    tumble_whole_begin(&work);
    do {
        const taken_t taken = measure(step);
        ticks += taken.ticks;
        most.ticks = (taken.ticks > most.ticks) ? taken.ticks : most.ticks;
        most.stack_bytes = (taken.stack_bytes > most.stack_bytes) ? taken.stack_bytes : most.stack_bytes;
        steps++;
    } while (more);
    put("whole ");
    put(name);
    put_number(steps);
    put_number((uint32_t)(ticks * INSTRUCTIONS_PER_TICK));
    put_number(most.ticks * INSTRUCTIONS_PER_TICK);
    put_number(most.stack_bytes);
    put("\n");
}

int main(void)
{
    stand = benchmark_stand;
    stand.seat_rad = 1e-4;
    stand.platform_rad = 1e-4;
    for (size_t i = 0; i < (sizeof cases / sizeof cases[0]); i++) {
        test(cases[i].name, cases[i].schedule, cases[i].means);
    }
    return 0;
}
