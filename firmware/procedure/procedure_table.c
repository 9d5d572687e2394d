#include "procedure/procedure_internal.h"

#include <stddef.h>

#define LASTS(member) (uint8_t)offsetof(tumble_procedure_config_t, member)
#define TO(state) (uint8_t)TUMBLE_STATE_##state
#define BECAUSE(reason) (uint8_t)TUMBLE_REASON_##reason

static_assert(sizeof(tumble_procedure_config_t) <= UINT8_MAX, "an offset into the configuration is one byte");

/* The two commands of a run that may come at any time, and those of a moment when the table is at rest. */
#define IN_MOTION COMMAND_ABORT
#define AT_REST (COMMAND_ABORT | COMMAND_REPEAT)

/* The way of a run. `>`: passed at once when it is so already. Every state of a run leads to FAULT or ABORT too.
 *
 *     IDLE --start--> PREFLIGHT --> WARM_UP --> NEXT --> WAIT_MOUNTING > HOME > MOVE --> SETTLE --> AVERAGE
 *                         ^                     ^  |     (confirmed)   (homed)             ^         |  |
 *                      resume                   |  |                                       + another +  |
 *                         |                     |  | nothing is left                         attempt    |
 *                       FAULT                   |  |                                                    |
 *                                               +--|------------ the position has its mean -------------+
 *                                                  v
 *                                                SOLVE --> VERIFY --> PROPOSE --> DONE
 *
 * No run goes on for ever: attempts are counted, and every state of a run that waits has a timeout.
 */
/* clang-format off */
const tumble_row_t tumble_procedure_rows[TUMBLE_STATE_COUNT] = {
    [TUMBLE_STATE_IDLE] = {
        .commands = COMMAND_START | COMMAND_RESUME, /* a run that lost power */
    },
    [TUMBLE_STATE_PREFLIGHT] = {
        .enter = tumble_preflight_enter, .poll = tumble_preflight_poll, .sample = tumble_preflight_sample,
        .timeout = LASTS(preflight_timeout_ms), .late = tumble_preflight_late,
        .done = TO(WARM_UP),
        .watch = WATCH_BUS, .commands = IN_MOTION,
    },
    [TUMBLE_STATE_WARM_UP] = {
        .enter = tumble_warm_up_enter, .sample = tumble_warm_up_sample,
        .timeout = LASTS(warm_up_timeout_ms), .late_reason = BECAUSE(WARM_UP),
        .done = TO(NEXT),
        .watch = WATCH_BUS | WATCH_STAND | WATCH_BLOCK | WATCH_SAMPLES, .commands = IN_MOTION,
    },
    [TUMBLE_STATE_NEXT] = {
        .enter = tumble_next_enter,
        .done = TO(WAIT_MOUNTING),
        .other = TO(SOLVE), /* nothing is left to measure */
    },
    [TUMBLE_STATE_WAIT_MOUNTING] = {
        .poll = tumble_wait_mounting_poll,
        .timeout = LASTS(mounting_timeout_ms), .late_reason = BECAUSE(MOUNTING_NOT_CONFIRMED),
        .done = TO(HOME),
        .watch = WATCH_BUS | WATCH_STAND, .commands = AT_REST | COMMAND_CONFIRM,
    },
    [TUMBLE_STATE_HOME] = {
        .enter = tumble_home_enter, .poll = tumble_home_poll,
        .timeout = LASTS(home_timeout_ms), .late_reason = BECAUSE(HOMING),
        .done = TO(MOVE),
        .watch = WATCH_BUS | WATCH_STAND | WATCH_BLOCK, .commands = IN_MOTION,
    },
    [TUMBLE_STATE_MOVE] = {
        .enter = tumble_move_enter, .poll = tumble_move_poll,
        .timeout = LASTS(move_timeout_ms), .late_reason = BECAUSE(TARGET_NOT_REACHED),
        .done = TO(SETTLE),
        .watch = WATCH_BUS | WATCH_STAND | WATCH_BLOCK, .commands = IN_MOTION,
    },
    [TUMBLE_STATE_SETTLE] = {
        .enter = tumble_settle_enter, .poll = tumble_settle_poll, .sample = tumble_settle_sample,
        .timeout = LASTS(settle_timeout_ms), .late = tumble_settle_late,
        .done = TO(AVERAGE),
        .other = TO(SETTLE), /* another attempt */
        .watch = WATCH_BUS | WATCH_STAND | WATCH_BLOCK | WATCH_SAMPLES | WATCH_ANGLE, .commands = AT_REST,
    },
    [TUMBLE_STATE_AVERAGE] = {
        .enter = tumble_average_enter, .poll = tumble_average_poll, .sample = tumble_average_sample,
        .timeout = LASTS(average_timeout_ms), .late = tumble_average_late,
        .done = TO(NEXT),
        .other = TO(SETTLE), /* another attempt */
        .watch = WATCH_BUS | WATCH_STAND | WATCH_BLOCK | WATCH_SAMPLES | WATCH_ANGLE, .commands = AT_REST,
    },
    [TUMBLE_STATE_SOLVE] = {
        .poll = tumble_solve_poll, .done = TO(VERIFY), .pauses = true, .commands = AT_REST,
    },
    [TUMBLE_STATE_VERIFY] = {
        .poll = tumble_verify_poll, .done = TO(PROPOSE), .pauses = true, .commands = AT_REST,
    },
    [TUMBLE_STATE_PROPOSE] = {
        .poll = tumble_propose_poll, .done = TO(DONE), .pauses = true, .commands = AT_REST,
    },
    [TUMBLE_STATE_DONE] = {
        .commands = COMMAND_START | COMMAND_REPEAT,
    },
    [TUMBLE_STATE_FAULT] = {
        .enter = tumble_fault_enter, .poll = tumble_fault_poll,
        .commands = AT_REST | COMMAND_CONFIRM | COMMAND_RESUME,
    },
    [TUMBLE_STATE_ABORT] = {
        .enter = tumble_abort_enter, .poll = tumble_abort_poll,
        .commands = COMMAND_START,
    },
};
/* clang-format on */
