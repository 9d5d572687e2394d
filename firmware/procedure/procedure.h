/* procedure.h - the state machine that walks a schedule: mount, home, turn, settle, average, solve, verify, propose.
 *
 * It knows the core and the stand interface, no bus and no clock: time comes in as a parameter, samples are handed in.
 * The caller owns the object and every configuration; nothing is allocated, no function waits. Not re-entrant.
 *
 * What decides about settling and averaging is only what arrives: the stand's report of being in position, then the
 * block's samples with their own counters and timestamps. The time parameter drives timeouts alone, so a recorded run
 * replays to the same bits anywhere. Every state that waits for something has a bounded time.
 */
#ifndef TUMBLE_PROCEDURE_PROCEDURE_H
#define TUMBLE_PROCEDURE_PROCEDURE_H

#include "core/averaging.h"
#include "core/calibration.h"
#include "core/estimator.h"
#include "core/schedule.h"
#include "core/verification.h"
#include "procedure/states.h"
#include "stand/stand.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum { TUMBLE_ESTIMATE_AVERAGED = 0, TUMBLE_ESTIMATE_REFINED, TUMBLE_ESTIMATE_LEAST_SQUARES } tumble_estimate_t;

/* One sample of the block, as it leaves the sample source (CAN frames or a board's own converter). */
typedef struct {
    tumble_sample_t raw;       /* counts and 16-bit sample counter */
    uint16_t timestamp_ms;     /* the block's own clock; wraps at 4096 (12 bits) */
    uint8_t status;            /* the block's status bits, 0: healthy */
    int8_t temperature_half_c; /* block temperature in half degrees Celsius */
} tumble_block_sample_t;

typedef struct {
    const tumble_schedule_t *schedule;
    const tumble_averaging_config_t *averaging; /* min_samples there is the smallest; samples below is what is taken */
    tumble_estimate_t estimate;
    uint32_t samples;               /* per position */
    double v_per_count;             /* size of one count, V */
    double nominal_scale_v_per_g;   /* signed; for the check of the mounting */
    double gravity_limit_g;         /* limit of the gravity check */
    double closure_limit_g;         /* |U9 - U1| over the nominal scale that calls a slip; above 0 */
    double position_tolerance_deg;  /* actual against commanded angle that calls a slip; above 0 */
    double approach_deg;            /* every angle is approached upwards, from at least this far below; 0: no matter */
    double cable_min_deg;           /* the table may turn from here ... */
    double cable_max_deg;           /* ... to here; the procedure turns back rather than go beyond */
    uint16_t settle_ms;             /* by the block's timestamps, after the stand is in position; below 4096 */
    uint16_t max_corrupted;         /* corrupted frames allowed per position */
    uint8_t retries;                /* times that one position is repeated by itself before it is a fault */
    int8_t warm_up_band_half_c;     /* temperature must stay within this band ... */
    uint16_t warm_up_samples;       /* ... for so many samples in a row; 0: no warm-up */
    uint32_t preflight_timeout_ms;
    uint32_t warm_up_timeout_ms;
    uint32_t mounting_timeout_ms;
    uint32_t home_timeout_ms;
    uint32_t move_timeout_ms;
    uint32_t settle_timeout_ms;
    uint32_t average_timeout_ms;
    uint32_t sample_timeout_ms;     /* silence of the block that is a fault, in states that need samples */
} tumble_procedure_config_t;

#endif
