/* gains.h - the estimator `optimal` of this board, and the memory that its gains lie in (docs/files.md).
 *
 * In the emulator a file is loaded there; on the chip it is for a mapped flash, which this board has none of yet.
 * Whether there is a record, and the right one, is asked when a calibration begins.
 */
#ifndef ZCU102_GAINS_H
#define ZCU102_GAINS_H

#include "tumble/navcomp.h"

/* Null: the board has no memory for gains, and refuses the estimator. */
const tumble_lent_t *zcu102_lent(void);

#endif
