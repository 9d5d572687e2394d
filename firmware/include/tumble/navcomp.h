/* tumble/navcomp.h - the navigation computer: the one place where the parts meet, driven by one non-blocking step.
 *
 * One configuration names the parts of a computer: the port of the board (tumble/port.h), the stand (tumble/stand.h:
 * its kind, its profile, the memory for its object), a source of samples or the block's frames, and what is kept over a
 * loss of power. Then there is one loop.
 *
 * The shortest program, for the standard stand, which a drive turns:
 *
 *     #include "navcomp/standard.h"
 *
 *     void calibrate(const tumble_port_t *port)
 *     {
 *         static tumble_drive402_t drive;
 *         static tumble_navcomp_t navcomp;
 *         static tumble_navcomp_config_t config;
 *         config = tumble_standard_navcomp;
 *         config.port = port;
 *         config.stand_memory = &drive;
 *         config.stand_bytes = sizeof drive;
 *         if ((tumble_navcomp_init(&navcomp, &config) == TUMBLE_OK) &&
 *             (tumble_navcomp_command(&navcomp, TUMBLE_COMMAND_START, 0) == TUMBLE_OK)) {
 *             for (;;) {
 *                 tumble_navcomp_step(&navcomp);
 *                 // wait for a frame, but not beyond tumble_navcomp_next_deadline_us(&navcomp)
 *             }
 *         }
 *     }
 *
 * One object, owned by the caller, holds everything; the configuration is const and must outlive it. Nothing is
 * allocated, no function waits, nothing is global: two objects are two computers. Not re-entrant on one object.
 *
 * On the bus it is the NMT master: it starts stand and block, watches their heartbeats, stops the axis when
 * something fails, and serves its own object dictionary (objects.h) to outsiders by SDO.
 *
 * Replay: what is averaged depends only on the frames received, their order, and the block's own counter and
 * timestamps. The port's clock drives timeouts, heartbeats and pacing alone.
 */
#ifndef TUMBLE_NAVCOMP_H
#define TUMBLE_NAVCOMP_H

#include "tumble/core.h"
#include "tumble/port.h"
#include "tumble/stand.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" { /* for those of the rooms as well */
#endif

#include "navcomp/commands.h"
#include "navcomp/objects.h"
#include "navcomp/service.h"
#include "procedure/procedure.h"
#include "sample/block_frames.h"
#include "sample/source.h"

struct tumble_navcomp;

/* What a computer with non-volatile memory is led by besides (navcomp/keeper.h); a board without one links nothing of it. */
typedef struct tumble_keeping {
    /* At power-on, when everything else of the computer is ready. tumble_navcomp_init returns what it returns. */
    tumble_status_t (*init)(void *keeper, struct tumble_navcomp *navcomp);

    /* In every step that does more than take samples, at its end. Returns when its next step is due if nothing else
     * happens (us); a moment in the past means at once. */
    uint64_t (*step)(void *keeper, uint64_t now_us);

    /* Every sample of the block, after the procedure has taken it; `averaged`: it went into a mean. */
    void (*sample)(void *keeper, const tumble_block_sample_t *sample, bool averaged);

    /* Every command, instead of tumble_navcomp_obey, which it may call. Returns as tumble_navcomp_command. */
    tumble_status_t (*command)(void *keeper, tumble_command_t command, uint8_t argument);

    /* An NMT reset of the node has set navcomp's own configuration back to the board's. */
    void (*reset)(void *keeper);

    const tumble_node_extension_t *objects; /* and PDOs, behind navcomp's own; may be null */
} tumble_keeping_t;

/* What a bench wants to record; may be null. */
typedef struct {
    void *context; /* handed back */

    /* A sample went into the mean `taken.index`, as its number `taken.ordinal`. Ordinal 1: that position begins
     * (again), and whatever was recorded for it before has been discarded. */
    void (*on_sample_averaged)(void *context, tumble_taken_t taken, const tumble_block_sample_t *sample);
} tumble_navcomp_hooks_t;

/* What a computer lends that serves a second SDO client (1201h) at the same time: on its own identifiers, with command
 * arguments of its own. Private. */
typedef struct {
    tumble_second_server_t server;
    tumble_navcomp_objects_t objects;
} tumble_second_client_t;

typedef struct {
    const tumble_port_t *port;
    const tumble_procedure_config_t *procedure; /* copied by init: some of its numbers can be written over CAN */
    const tumble_stand_kind_t *stand;           /* &tumble_drive402_kind, &tumble_operator_kind or your own */
    const void *stand_profile;                  /* of that kind; const */
    void *stand_memory;                         /* for its object: all that it keeps */
    uint32_t stand_bytes;                       /* of that memory */
    const tumble_sample_source_t *source;       /* null: the block's frames over CAN */
    const tumble_navcomp_hooks_t *hooks;        /* may be null */
    const struct tumble_declared *declared;     /* the stand, for navcomp/uncertainty.h; null: no uncertainties */
    const tumble_keeping_t *keeping;            /* &tumble_keeper_calls; null: keeps nothing over a loss of power */
    void *keeper;                               /* with `keeping`: the tumble_keeper_t */
    tumble_second_client_t *second_client;      /* null: one SDO server is all */
    uint32_t block_period_us;      /* of its samples. 127 of them must outlast procedure->sample_timeout_ms and a
                                    * heartbeat of ours together (block_frames.h); ignored with a source of one's own */
    uint16_t heartbeat_ms;         /* our own, above 0; what others consume must be longer */
    uint16_t heartbeat_timeout_ms; /* silence of stand or block that counts as its loss, above 0 */
    uint8_t node;                  /* node numbers, 1 to 127, all different */
    uint8_t stand_node;            /* of a stand on the bus; 0 for one that is not */
    uint8_t block_node;            /* ignored with a sample source of the board's own */
} tumble_navcomp_config_t;

/* Counted by navcomp itself; monotonic since init, they stop at UINT32_MAX. */
typedef struct {
    uint32_t frames_ignored;   /* of no interest to this node */
    uint32_t source_corrupted; /* samples that a board's own source found spoilt */
    uint32_t source_faults;    /* answers of such a source outside its list */
    uint32_t commands_refused;
    uint32_t heartbeats_lost; /* of stand and block: from present to silent */
    uint32_t boot_ups;        /* of stand and block */
    uint32_t starts;          /* NMT start commands given to them */
    uint32_t emergencies;     /* of stand and block, "no error" included */
    uint32_t foreign;         /* frames that only this node may send: set-points, its own heartbeat */
} tumble_navcomp_events_t;

/* The object. Its fields are private: read them through the functions below. */
typedef struct tumble_navcomp {
    int8_t temperature_half_c;
    uint8_t restart; /* an NMT reset came: what of */
    bool woken;      /* this step has more to do than to take samples */
    bool more;       /* the next one has something to do at once */
    const tumble_navcomp_config_t *config;
    uint32_t shown;            /* the last content of the state PDO */
    uint32_t run_number;       /* 2007h: runs begun since power-on; an NMT reset leaves it */
    uint64_t service_until_us; /* the service level ends there; 0: it is not open */
    uint64_t stepped_us;       /* clock of the last step */
    uint64_t due_us;           /* of the next one if no frame comes */
    uint64_t block_start_us;   /* not before: the next NMT start for the block */
    tumble_stand_t stand;
    tumble_procedure_config_t procedure_config;
    tumble_node_config_t node_config;
    tumble_node_t node;
    tumble_drive_mirror_t mirror;
    tumble_procedure_t procedure;
    tumble_block_receiver_t block;
    tumble_navcomp_events_t events;
    tumble_navcomp_objects_t objects;
} tumble_navcomp_t;

static_assert(sizeof(tumble_navcomp_t) <= (((sizeof(void *) == 4U) ? 2560U : 3072U) + sizeof(tumble_averaging_t)),
              "with 36 positions 4 kB of RAM are all there is");

/* Check the configuration and get ready; nothing is sent before the first step. What the procedure's configuration says
 * is checked when a run starts.
 * Returns TUMBLE_OK, or TUMBLE_E_ARGUMENT: a null pointer that may not be null, a time of 0, node numbers out of range
 * or equal, a sample timeout too long for the block's counter, too little memory for the stand, a profile that its kind
 * refuses. With `keeping`, also what its init returns (tumble_sets_init: TUMBLE_E_ARGUMENT, TUMBLE_E_NV). */
tumble_status_t tumble_navcomp_init(tumble_navcomp_t *navcomp, const tumble_navcomp_config_t *config);

/* One step: take the received frames, advance timers, stand and procedure, send what is due. It returns at once; it
 * takes at most so many frames. Call it whenever a frame has come or the deadline is over; more often does no harm. */
#define TUMBLE_NAVCOMP_MAX_FRAMES_PER_STEP 64
void tumble_navcomp_step(tumble_navcomp_t *navcomp);

/* When the next step is due if no frame comes (us, port's clock); a moment in the past means at once. Never more than a
 * heartbeat away. Timeouts of the nodes, the stand and the procedure are deadlines too. */
uint64_t tumble_navcomp_next_deadline_us(const tumble_navcomp_t *navcomp);

/* Give a command (navcomp/commands.h says what `argument` means for each; otherwise it is ignored). It takes effect at
 * the next step at the latest.
 * Returns TUMBLE_OK, TUMBLE_E_STATE (not allowed in this state), TUMBLE_E_ARGUMENT (no such command, position or
 * mounting). Refusals are counted. */
tumble_status_t tumble_navcomp_command(tumble_navcomp_t *navcomp, tumble_command_t command, uint8_t argument);

/* TUMBLE_COMMAND_TURN_AXIS to this angle (degrees of the table), for the validation of a fixture. It turns straight
 * there, without the approach from below. Allowed between runs only (IDLE, DONE, ABORT), after
 * TUMBLE_COMMAND_HOME_AXIS, which is also allowed between runs only, has homed the table. TUMBLE_COMMAND_ABORT stops
 * the table; it is refused only where nothing turns.
 * Returns TUMBLE_OK, TUMBLE_E_STATE (not now), TUMBLE_E_ARGUMENT (not within the cable's limits). */
tumble_status_t tumble_navcomp_turn(tumble_navcomp_t *navcomp, double angle_deg);

/* TUMBLE_COMMAND_ACCEPT of this proposal: the CRC at the end of its record (tumble_set_t.record_crc).
 * Returns TUMBLE_OK, TUMBLE_E_STATE (not now, or there is no proposal), TUMBLE_E_ARGUMENT (it is another one). */
tumble_status_t tumble_navcomp_accept(tumble_navcomp_t *navcomp, uint32_t proposal);

/* Where the calibration stands. */
typedef struct {
    tumble_progress_t run;
    bool has_mean; /* the open mean holds two samples or more; else the two below are 0 */
    double mean_v[TUMBLE_CHANNELS];
    double standard_error_v[TUMBLE_CHANNELS];
    tumble_stand_state_t stand;
    double angle_deg;          /* actual, as last reported */
    int8_t temperature_half_c; /* of the block's last sample */
    uint8_t stand_fault;       /* tumble_stand_fault_t */
    uint8_t limited;           /* 1: the drive itself keeps to the cable's limits (607Dh) */
    uint8_t rung;              /* tumble_stop_rung_t: how far a stop under way has gone */
    tumble_stand_refusal_t refusal;
    struct { /* the values above, one byte each, for the object dictionary */
        uint8_t state;
        uint8_t reason;
        uint8_t failed_in;
        uint8_t status;
        uint8_t stand;
        uint8_t stays_bolted;
    } as_byte;
} tumble_navcomp_progress_t;

void tumble_navcomp_progress(const tumble_navcomp_t *navcomp, tumble_navcomp_progress_t *progress);

/* The result, valid until the next command. Returns TUMBLE_OK, or TUMBLE_E_STATE when there is none. */
tumble_status_t tumble_navcomp_result(const tumble_navcomp_t *navcomp, tumble_result_t *result);

/* All counters in one copy. */
typedef struct {
    tumble_link_counters_t link; /* frames sent and received, busy, down, malformed */
    tumble_navcomp_events_t events;
    tumble_block_counters_t block;         /* samples ok, lost, repeated, reordered, corrupted */
    tumble_averaging_counters_t averaging; /* refused by the gates of an open position */
    tumble_procedure_counters_t procedure;
    tumble_stop_counters_t stop; /* zeros if the stand counts none */
} tumble_navcomp_counters_t;

void tumble_navcomp_counters(const tumble_navcomp_t *navcomp, tumble_navcomp_counters_t *counters);

/* Is a person asked for an angle, and which? */
bool tumble_navcomp_request(const tumble_navcomp_t *navcomp, double *angle_deg);

/* As TUMBLE_COMMAND_CONFIRM_ANGLE, but with the angle (degrees) at which the head really stands.
 * Returns TUMBLE_OK, TUMBLE_E_STATE (nothing is requested), TUMBLE_E_ARGUMENT (too far from the request). */
tumble_status_t tumble_navcomp_confirm_angle(tumble_navcomp_t *navcomp, double angle_deg);

/* What the stand refused of its configuration; zeros when nothing. */
tumble_stand_refusal_t tumble_navcomp_drive_refusal(const tumble_navcomp_t *navcomp);

/* The procedure, to be read: finished means, closure. Valid as long as the object. */
const tumble_procedure_t *tumble_navcomp_procedure(const tumble_navcomp_t *navcomp);

#ifdef __cplusplus
}
#endif

#endif
