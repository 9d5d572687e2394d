/* main.c - run one estimator REPEATS times on the target; print the ticks of a 25 MHz clock that took, the stack it used, its
 * status and the bits of its result. With QEMU's -icount shift=0 an instruction takes 1 ns, so a tick is 40 instructions.
 */
#include "benchmark.h"
#include "data.h"
#include "measure.h"
#include "tumble/core.h"

#include <string.h>

#define REPEATS 25
#define PAINT 0xA5A5A5A5U
#define SYSTICK ((volatile uint32_t *)0xE000E010)

extern uint32_t stack_bottom[];

static volatile tumble_status_t status;

#if CANDIDATE == 0
#define ESTIMATE() TUMBLE_OK
#elif CANDIDATE == 1
#define ESTIMATE() tumble_estimate_refined(&tumble_schedule_paper, &benchmark_means, &found, NULL)
#elif CANDIDATE == 2
#define ESTIMATE() tumble_estimate_least_squares(&tumble_schedule_paper, &benchmark_means, &found, NULL)
#elif CANDIDATE == 3
#define ESTIMATE() tumble_estimate_gains(&benchmark_table, &tumble_schedule_paper, &benchmark_means, &found)
#elif CANDIDATE == 4
static tumble_optimal_t optimal;
#define ESTIMATE() tumble_estimate_optimal(benchmark_record, &tumble_schedule_paper, &benchmark_means, &found, &optimal)
#elif CANDIDATE == 5
static const tumble_gain_record_t *record;
#define ESTIMATE()                                                                                                     \
    tumble_gain_record_open(benchmark_record, benchmark_record->size_bytes, &tumble_schedule_paper, &record)
#elif CANDIDATE == 6
#define ESTIMATE() dense_normal_equations(&tumble_schedule_paper, &benchmark_means, &found)
#elif CANDIDATE == 7
#define ESTIMATE() dense_householder(&tumble_schedule_paper, &benchmark_means, &found)
#elif CANDIDATE == 8
#define BEGIN() samples_begin()
#define ESTIMATE() samples_none()
#elif CANDIDATE == 9
#define BEGIN() samples_begin()
#define ESTIMATE() samples_without_gates()
#elif CANDIDATE == 10
#define BEGIN() samples_begin()
#define ESTIMATE() samples_with_gates()
#elif CANDIDATE == 11
#define BEGIN() samples_begin()
#define ESTIMATE() samples_divide()
#elif CANDIDATE == 12
#define ESTIMATE() shared_normal_matrix(&tumble_schedule_paper, &benchmark_means, &found)
#elif CANDIDATE == 13
#define ESTIMATE() tumble_uncertainty_refined(&judged, &uncertainty, NULL)
#elif CANDIDATE == 14
#define ESTIMATE() tumble_uncertainty_least_squares(&judged, &uncertainty, NULL)
#elif CANDIDATE == 16
#define ESTIMATE() tumble_estimate_refined(&tumble_schedule_three_mountings, &benchmark_three_mountings, &found, NULL)
#elif CANDIDATE == 17
#define ESTIMATE() tumble_estimate_refined(&tumble_schedule_diagonal, &benchmark_diagonal, &found, NULL)
#elif CANDIDATE == 18
#define BEGIN() samples_begin()
#define ESTIMATE() samples_noise()
#elif CANDIDATE == 19
#define ESTIMATE() tumble_uncertainty_refined(&one_judged, &uncertainty, NULL)
#elif CANDIDATE == 20
#define ESTIMATE() tumble_uncertainty_least_squares(&one_judged, &uncertainty, NULL)
#elif CANDIDATE == 21
#define BEGIN() samples_begin()
#define ESTIMATE() samples_in_blocks()
#elif CANDIDATE == 22
#define ESTIMATE() tumble_estimate_inclined(&tumble_schedule_inclined, &benchmark_inclined, &found, NULL)
#elif CANDIDATE == 23 || CANDIDATE == 24
#define ESTIMATE() tumble_uncertainty_inclined(&inclined_judged, &uncertainty, NULL)
#elif CANDIDATE == 25
#define BEGIN() thermal_begin()
#define ESTIMATE() tumble_thermal_calibration(&thermal, 31.0, &found)
#elif CANDIDATE == 26
#define BEGIN() thermal_begin()
#define ESTIMATE() tumble_thermal_update(&thermal, &uncertainty, &growth, &warm_run)
#elif CANDIDATE == 15
#define ESTIMATE() tumble_uncertainty_gains(&benchmark_table, &judged, &uncertainty)
#endif

#if CANDIDATE >= 13 && CANDIDATE <= 15
static tumble_uncertainty_t uncertainty;
static const tumble_judged_run_t judged = {
    .schedule = &tumble_schedule_paper, .stand = &benchmark_stand, .coefficients = &benchmark_coefficients};
#define FOUND uncertainty
#elif CANDIDATE == 19 || CANDIDATE == 20
static tumble_uncertainty_t uncertainty;
static const tumble_noise_t noise = {
    .variance_v2 = {1e-7, 2e-7, 3e-7}, .line_v2 = {1e-8, 2e-8, 3e-8}, .lengths_per_sample = 1.0 / 16.0, .above = 7U};
static const tumble_judged_run_t one_judged = {.schedule = &tumble_schedule_paper,
                                               .stand = &benchmark_stand,
                                               .coefficients = &benchmark_coefficients,
                                               .only = 0x200, /* the longest */
                                               .noise = &noise};
#define FOUND uncertainty
#elif CANDIDATE == 23 || CANDIDATE == 24
static tumble_uncertainty_t uncertainty;
static const tumble_judged_run_t inclined_judged = {.schedule = &tumble_schedule_inclined,
                                                    .stand = &benchmark_stand,
                                                    .coefficients = &benchmark_coefficients,
                                                    .only = (CANDIDATE == 24) ? 0x200 : 0};
#define FOUND uncertainty
#elif CANDIDATE == 25 || CANDIDATE == 26
static tumble_thermal_t thermal = {.reference_c = 21.5, .lowest_c = -40.0, .highest_c = 60.0};
static void thermal_begin(void)
{
    for (int m = 0; m < TUMBLE_THERMAL_POWERS; m++) {
        const double size = (m == 0) ? 1.0 : (m == 1) ? 1e-4 : 1e-7;
        for (int i = 0; i < TUMBLE_CHANNELS; i++) {
            for (int j = 0; j < TUMBLE_CHANNELS; j++) {
                thermal.power[m].k_v_per_g[i][j] = size * benchmark_coefficients.k_v_per_g[i][j];
            }
            thermal.power[m].u0_v[i] = size * benchmark_coefficients.u0_v[i];
        }
    }
}
#if CANDIDATE == 25
static tumble_calibration_t found;
#define FOUND found
#else
#define U 1.1e-5
static const tumble_uncertainty_t growth = {{{U, U, U}, {U, U, U}, {U, U, U}}, {U, U, U}};
static const tumble_uncertainty_t u_run = {{{U, U, U}, {U, U, U}, {U, U, U}}, {U, U, U}};
static tumble_uncertainty_t uncertainty = {{{U, U, U}, {U, U, U}, {U, U, U}}, {U, U, U}};
static const tumble_thermal_run_t warm_run = {31.0, &benchmark_coefficients, &u_run};
#define FOUND uncertainty
#endif
#else
static tumble_coefficients_t found;
#define FOUND found
#endif

#ifndef BEGIN
#define BEGIN()
#endif

__attribute__((noinline)) static void run(void)
{
    status = ESTIMATE();
}

/* Fill what lies below this function's own frame; what is still paint afterwards was not used. */
__attribute__((noinline)) static uint32_t stack_used(void)
{
    uint32_t *const here = __builtin_frame_address(0);
    uint32_t *const top = here - 16;
    uint32_t *word = stack_bottom;
    while (word < top) {
        *word++ = PAINT;
    }
    run();
    for (word = stack_bottom; *word == PAINT; word++) {
    }
    return (uint32_t)((char *)top - (char *)word);
}

static void put_word(uint32_t word)
{
    put_decimal(word);
    put(" ");
}

int main(void)
{
    SYSTICK[1] = 0xFFFFFFU;
    SYSTICK[2] = 0;
    SYSTICK[0] = 5; /* on, processor clock, no interrupt */
    BEGIN();
    const uint32_t stack = stack_used();
    const uint32_t before = SYSTICK[2];
    for (int i = 0; i < REPEATS; i++) {
        run();
    }
    const uint32_t after = SYSTICK[2];
    uint32_t bits[2 * TUMBLE_COEFFICIENTS];
    memcpy(bits, &FOUND, sizeof bits);
    put_word((before - after) & 0xFFFFFFU);
    put_word(stack);
    put_word((uint32_t)status);
    for (int i = 0; i < 2 * TUMBLE_COEFFICIENTS; i++) {
        put_word(bits[i]);
    }
    return 0;
}
