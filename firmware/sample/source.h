/* source.h - where samples come from: frames over CAN, or a board's own converter.
 *
 * Either way a sample ends in the same call into the procedure, with the block's own counter, timestamp and status, so
 * nothing behind this seam can tell the two apart. Frames over CAN are the default and need no table: navcomp hands the
 * frames that it drains to the receiver of block_frames.h. A board that reads its converter itself fills in this const
 * table of one non-blocking function instead; navcomp then ignores the block's frames and its heartbeat.
 */
#ifndef TUMBLE_SAMPLE_SOURCE_H
#define TUMBLE_SAMPLE_SOURCE_H

#include "sample/block_sample.h"
#include "tumble/status.h"

typedef struct {
    void *context; /* handed to the function */

    /* Take the oldest sample. TUMBLE_OK; TUMBLE_E_PORT_EMPTY: none is waiting; TUMBLE_E_CRC or TUMBLE_E_FRAME: one was
     * there but spoilt, it is gone and counts as corrupted; anything else counts as a fault of the port and ends the
     * draining until the next step. The counter must grow by one per sample, lost ones included, and wrap at 2^16. */
    tumble_status_t (*take)(void *context, tumble_block_sample_t *sample);
} tumble_sample_source_t;

#endif
