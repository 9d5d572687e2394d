/* keeping.h - the seam behind which a navigation computer keeps what it found.
 *
 * A board with non-volatile memory sets tumble_navcomp_config_t.keeping to &tumble_keeper_calls and .keeper to a
 * tumble_keeper_t (keeper.h); one without names neither, and links nothing of them.
 */
#ifndef TUMBLE_NAVCOMP_KEEPING_H
#define TUMBLE_NAVCOMP_KEEPING_H

#include "canopen/node.h"
#include "navcomp/commands.h"
#include "procedure/procedure.h"
#include "tumble/status.h"

#include <stdbool.h>
#include <stdint.h>

struct tumble_navcomp;

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

#endif
