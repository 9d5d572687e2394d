/* paint_core.c - the stack that the core's functions really take, for paint.py to hold against what tools/budget says. */
#include "measure.h"
#include "tumble/core.h"

#include <stddef.h>

static tumble_means_t means;
static tumble_coefficients_t found = {{{2.0, 0.04, 0.03}, {0.02, 2.1, -0.04}, {0.01, 0.03, 1.9}}, {0.01, 0.02, 0.03}};
static tumble_calibration_t calibration;
static tumble_gravity_check_t check;
static tumble_intrinsic_t intrinsic;
static double three[3];
static tumble_averaging_t averaging;
static const tumble_averaging_config_t config = {1000000, 2, 0, 0, 1.0F, 1.0F};

static void averaged(void)
{
    (void)tumble_estimate_averaged(&tumble_schedule_paper, &means, &found, NULL);
}

static void refined(void)
{
    (void)tumble_estimate_refined(&tumble_schedule_paper, &means, &found, NULL);
}

static void least_squares(void)
{
    (void)tumble_estimate_least_squares(&tumble_schedule_paper, &means, &found, NULL);
}

static void validate(void)
{
    (void)tumble_schedule_validate(&tumble_schedule_paper, NULL);
}

static void identify(void)
{
    (void)tumble_schedule_identify(&tumble_schedule_paper, NULL, NULL);
}

static void invert(void)
{
    (void)tumble_calibration_invert(&found, &calibration);
}

static void intrinsics(void)
{
    (void)tumble_calibration_intrinsic(&found, &intrinsic);
}

static void gravity_check(void)
{
    (void)tumble_gravity_check(&tumble_schedule_paper, &means, &calibration, 3e-4, &check);
}

static void residual_rms(void)
{
    (void)tumble_residual_rms(&tumble_schedule_paper, &means, &found, three);
}

static void average(void)
{
    const tumble_sample_t samples[2] = {{{5, -7, 9}, 1, 0}, {{6, -7, 8}, 2, 0}};
    (void)tumble_averaging_init(&averaging, &config);
    (void)tumble_averaging_begin(&averaging, 0);
    (void)tumble_averaging_add(&averaging, &config, &samples[0]);
    (void)tumble_averaging_add(&averaging, &config, &samples[1]);
    (void)tumble_averaging_running(&averaging, three, found.u0_v);
    (void)tumble_averaging_finish(&averaging, &config);
}

#ifdef TUMBLE_CANARY
/* A frame that nobody has accounted for. */
static void canary(void)
{
    volatile uint8_t frame[1024];
    for (size_t i = 0; i < sizeof frame; i++) {
        frame[i] = 1;
    }
}
#endif

typedef struct {
    const char *name;
    void (*call)(void);
} row_t;

static const row_t rows[] = {
    {"averaged", averaged},
    {"refined", refined},
    {"least_squares", least_squares},
    {"validate", validate},
    {"identify", identify},
    {"invert", invert},
    {"intrinsic", intrinsics},
    {"gravity_check", gravity_check},
    {"residual_rms", residual_rms},
    {"average", average},
#ifdef TUMBLE_CANARY
    {"canary", canary},
#endif
};

int main(void)
{
    for (uint8_t p = 0; p < tumble_schedule_paper.position_count; p++) {
        double a_g[3];
        tumble_schedule_attitude(&tumble_schedule_paper, p, a_g);
        means.measured[p] = true;
        for (int i = 0; i < 3; i++) {
            means.u_v[p][i] = 2.0 * a_g[i] + 1e-3 * (double)p;
        }
    }
    for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
        put("stack ");
        put(rows[r].name);
        put(" ");
        put_decimal(measure(rows[r].call).stack_bytes);
        put("\n");
    }
    return 0;
}
