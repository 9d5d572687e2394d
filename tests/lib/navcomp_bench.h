/* navcomp_bench.h - a navigation computer on a fake port, with a scripted drive and a scripted block around it.
 *
 * Time jumps from event to event, so a whole calibration takes milliseconds.
 */
#ifndef TUMBLE_TESTS_NAVCOMP_BENCH_H
#define TUMBLE_TESTS_NAVCOMP_BENCH_H

#include "fake_port.h"
#include "scripted_config.h"
#include "suite.h"
#include "tumble/navcomp.h"

#include <string.h>

#define BENCH_SAMPLES 12U
#ifndef BENCH_LOG
#define BENCH_LOG 200000U
#endif
#define BENCH_COMMAND 0xFFFFU /* identifier of a log entry that is a command: its number and argument */

typedef struct {
    uint64_t time_us;
    uint32_t event; /* of the run: entries of one event waited together */
    tumble_can_frame_t frame;
} bench_entry_t;

typedef struct {
    fake_port_t fake;
    scripted_drive_t drive;
    scripted_block_t block;
    tumble_averaging_config_t averaging;
    tumble_procedure_config_t procedure;
    tumble_navcomp_hooks_t hooks;
    tumble_navcomp_config_t config;
    tumble_navcomp_t navcomp;
    tumble_drive402_t axis;       /* what navcomp knows of the drive */
    bench_entry_t log[BENCH_LOG]; /* what the firmware received */
    size_t logged;
    uint32_t events;
    int64_t recorded_sum[TUMBLE_MAX_POSITIONS][TUMBLE_CHANNELS]; /* by on_sample_averaged */
    uint32_t recorded[TUMBLE_MAX_POSITIONS];
    uint64_t last_averaged_us[TUMBLE_MAX_POSITIONS];
    bool keep_mounting; /* the operator confirms, but leaves the block as it is */
    bool never_confirm;
    /* A test's own hand in what travels; null: nothing. False: the frame is lost. */
    bool (*spoil)(tumble_can_frame_t *frame);
} bench_t;

extern bench_t bench; /* the one under test; who records has a second */

/* Everything but the navcomp itself, which `bench_power_on` starts: a test may change the configuration in between. */
void bench_init(bench_t *b);
void bench_begin(void); /* with `bench`, before each case */

void bench_power_on(bench_t *b);
void power_on_for(double seconds);                  /* `bench` */
void reset_by_nmt(uint8_t command, double seconds); /* `bench`; 0: it hears it in its next step */
tumble_navcomp_progress_t bench_progress(const bench_t *b);
tumble_navcomp_counters_t bench_counters(const bench_t *b);

/* Give a command, and log it. */
tumble_status_t bench_command(bench_t *b, tumble_command_t command, uint8_t argument);

/* Spoil and log what waits for the firmware. */
void bench_inspect(bench_t *b);

void bench_operate(bench_t *b);

/* The drive and the block hear what the firmware has sent. */
void bench_hear(bench_t *b, const tumble_can_frame_t *frame);

/* Then they do what is due. */
void bench_play(bench_t *b);

/* Time goes on when nothing is left to be done now: to the next event, at most to `end_us`. */
void bench_go_on(bench_t *b, uint64_t end_us);

/* One event: the firmware steps, the others hear and answer, time goes on. */
void bench_event(bench_t *b);

/* Until that state, or so many seconds are over; returns the state reached. */
tumble_state_t bench_run(bench_t *b, tumble_state_t until, double seconds);

void bench_pass(bench_t *b, double seconds);

/* What every host does: step, and again for as long as the next step is due at once. */
void bench_settle(bench_t *b);

/* Power on and start; the run is under way. */
void bench_start(bench_t *b);

/* The result has passed and is what the block of `bench` is. */
void assert_right_coefficients(void);

#endif
