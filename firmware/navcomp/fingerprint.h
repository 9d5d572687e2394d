/* fingerprint.h - what must not change while a run is on, as one number: so that a run that lost power is gone on with by
 * the configuration that it was begun with, or not at all. */
#ifndef TUMBLE_NAVCOMP_FINGERPRINT_H
#define TUMBLE_NAVCOMP_FINGERPRINT_H

#include "tumble/navcomp.h"

#include <stdint.h>

/* Of what is declared of the stand, and how it is turned. */
uint32_t tumble_stand_fingerprint(const tumble_navcomp_t *navcomp);

/* Of all that must not change in a run, with the serial number of the block and the sequence of the active set: a result
 * that was committed is no run to go on with. */
uint32_t tumble_run_fingerprint(const tumble_navcomp_t *navcomp, const char *serial, uint32_t sequence);

#endif
