/* standard.h - the configuration for the standard stand: a board has it until a commissioning record replaces it, and
 * the simulated world starts from it.
 *
 * The stand: the paper's, with its schedule, on a drive that counts in thousandths of a degree (also per second, and
 * per second squared) and turns at 90 deg/s and 180 deg/s^2. The block: 24 bits over +-10 V, -2 V/g, white noise of
 * 0.3 mV, 100 samples a second. At each position the axis rests for half a second, then 50 samples are averaged, and
 * the `refined` estimator makes coefficients of the means; residual gravity beyond 3e-4 g fails. Nodes: ours 1, the
 * drive 2, the block 3.
 *
 * A number that follows from others says so in its own comment. Timeouts leave room for a slow stand; a person has ten
 * minutes for a mounting, and the block has ten minutes to warm up.
 */
#ifndef TUMBLE_NAVCOMP_STANDARD_H
#define TUMBLE_NAVCOMP_STANDARD_H

#include "stand/drive402/drive402.h"
#include "tumble/navcomp.h"

extern const tumble_averaging_config_t tumble_standard_averaging;
extern const tumble_procedure_config_t tumble_standard_procedure;
extern const tumble_drive_profile_t tumble_standard_drive; /* one PDO each way */

/* Everything but the port, the hooks and the stand's memory, a tumble_drive402_t, which are null. */
extern const tumble_navcomp_config_t tumble_standard_navcomp;

#endif
