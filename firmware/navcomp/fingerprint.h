/* fingerprint.h - one number for all that must not change in a run, so that a run that lost power is resumed with the
 * configuration with which it began, or not at all. */
#ifndef TUMBLE_NAVCOMP_FINGERPRINT_H
#define TUMBLE_NAVCOMP_FINGERPRINT_H

#include "tumble/navcomp.h"

#include <stdint.h>

/* The fingerprint of the stand: what is declared of it, and how it is turned. */
uint32_t tumble_stand_fingerprint(const tumble_navcomp_t *navcomp);

/* The fingerprint of a run: all that must not change in it, with the serial number of the block and the sequence of the
 * active set, so that a run whose result was committed is not resumed. */
uint32_t tumble_run_fingerprint(const tumble_navcomp_t *navcomp, const char *serial, uint32_t sequence);

#endif
