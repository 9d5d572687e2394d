/* poller.h - the side of the gateway that speaks CAN: reads the node's objects again and again by SDO, and writes
 * commands, with a read of a poll that is due between two of them. One transfer at a time; never waits. A seam for
 * tests: all it knows of the bus is a port (tumble/port.h).
 *
 * It uses the node's second SDO server (1201h), so that the first one is left to others. After silence it tries the other
 * one, for a node may have the first one alone; when that answers, it is asked once whether there is a second.
 *
 * A snapshot is published whole or not at all. Objects named as marks are read before and after all others: when one
 * has changed meanwhile, the results may be a mixture, and all is read again; likewise when a transfer fails because
 * somebody else uses the node's SDO channel. It begins anew, too, when a command or setting was sent meanwhile: what is
 * published after a result has been read after it.
 *
 * As long as no mark changes, what the table says is kept is taken from the snapshot before; not after silence, nor
 * after the node has booted. Of that, a group of values that has keys is read anew as soon as one of its keys has
 * changed, or a setting of it was written here: the keys are read in every poll. The first key selects what the others
 * are of, and of a group that was read anew it is read once more in the end.
 */
#ifndef TUMBLE_GATEWAY_POLLER_H
#define TUMBLE_GATEWAY_POLLER_H

#include "canopen/sdo.h"
#include "commands.h"
#include "registers.h"

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

#define GATEWAY_MAX_TORN 3U    /* polls torn one after the other; then the rest of the period is waited for */
#define GATEWAY_MAX_ANEW 8U    /* times that a poll begins anew because of what is written meanwhile; then it goes on */
#define GATEWAY_KEPT_POLLS 60U /* after so many all is read anew, whatever the marks say */
#define GATEWAY_MARK_BYTES 8U

typedef enum { GATEWAY_LINK_UNKNOWN = 0, GATEWAY_LINK_UP, GATEWAY_LINK_SILENT, GATEWAY_LINK_DOWN } gateway_link_t;

typedef struct {
    uint32_t number; /* 0: none yet */
    uint64_t taken_us;
    uint32_t ended;                    /* commands that had their result before its first value was read */
    uint16_t words[GATEWAY_INPUT_END]; /* 0 below GATEWAY_OWN_END */
} gateway_snapshot_t;

/* A mark or a key as it was read. */
typedef struct {
    uint32_t refusal;
    uint8_t size;
    uint8_t bytes[GATEWAY_MARK_BYTES];
} gateway_mark_t;

typedef struct {
    tumble_link_t link;
    tumble_sdo_client_t client;
    uint32_t *counters; /* GATEWAY_COUNTERS of them */
    uint64_t period_us;
    uint64_t next_us; /* of the next poll */
    uint8_t node;
    uint8_t phase; /* private; likewise `doing`, what the transfer under way is for, and `part` of a command */
    uint8_t doing;
    uint8_t part;
    uint8_t link_state; /* gateway_link_t */
    bool has_looked;    /* for a second server, since it uses the first */
    uint8_t torn;       /* in a row */
    uint8_t begun_anew; /* because of what was written meanwhile */
    uint16_t place;     /* in the table that the phase walks */
    bool is_fresh;      /* this poll reads what is kept as well */
    bool is_partial;    /* the node could not give a value that it has: its memory was at work */
    bool must_be_fresh; /* the next one does: the node may be another since */
    bool has_booted;    /* since this poll began */
    uint16_t kept;      /* polls since one did */
    gateway_mark_t marks[GATEWAY_MARKS + GATEWAY_KEYS]; /* of gateway_tells */
    gateway_mark_t published_marks[GATEWAY_MARKS + GATEWAY_KEYS];
    uint32_t dirty;   /* groups, as bits, that this poll reads anew */
    uint32_t written; /* groups whose settings have been written since the poll began; `stale`: before */
    uint32_t stale;
    uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
    gateway_snapshot_t building;
    gateway_snapshot_t published;
    gateway_queue_t queue; /* what is to be written: commands.h */
} gateway_poller_t;

static_assert(GATEWAY_GROUPS <= 32U, "groups are bits");

/* `period_us` from the beginning of a poll to that of the next. All pointers must outlive the poller. */
void gateway_poller_init(gateway_poller_t *poller, const tumble_port_t *port, uint8_t node, uint64_t period_us,
                         uint32_t *counters);

/* Take what has come, send what is due. */
void gateway_poller_step(gateway_poller_t *poller);

/* When step is due again if nothing comes before; one that is over: at once. Of the port's clock. */
uint64_t gateway_poller_next_us(const gateway_poller_t *poller);

#endif
