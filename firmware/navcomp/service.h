/* service.h - the service level (2006h) and the run number (2007h) of a navigation computer.
 *
 * Objects that protect the table or the coefficients are TUMBLE_ACCESS_SERVICE: the SDO server lets them be written at
 * service level only. A published key opens the level, and it ends by itself, so that nobody changes such an object by
 * mistake and no script leaves it open. It does not stop an attacker (docs/security.md). The board's own program needs
 * no level to write.
 *
 * Not re-entrant; called from where navcomp's functions are called.
 */
#ifndef TUMBLE_NAVCOMP_SERVICE_H
#define TUMBLE_NAVCOMP_SERVICE_H

#include "tumble/status.h"

#include <stdbool.h>
#include <stdint.h>

struct tumble_navcomp;

#define TUMBLE_SERVICE_KEY 0x76726573U /* "serv" */
#define TUMBLE_SERVICE_S 60U           /* how long one key opens it */
#define TUMBLE_SERVICE_PDO 4U          /* 1804h: sent when the level or the run number changes */

/* 2006h:1. The key opens the level or prolongs it, 0 ends it.
 * Returns TUMBLE_OK; TUMBLE_E_ARGUMENT (any other number: nothing changes); TUMBLE_E_STATE (the key, while a run is
 * on). */
tumble_status_t tumble_service_unlock(struct tumble_navcomp *navcomp, uint32_t key);

bool tumble_service_is_open(const struct tumble_navcomp *navcomp);
uint16_t tumble_service_left_s(const struct tumble_navcomp *navcomp); /* rounded up; 0: it is not open */

/* How many runs have begun since power-on: the number of the present one, or of the last. Stops at UINT32_MAX. */
uint32_t tumble_service_runs(const struct tumble_navcomp *navcomp);

/* For navcomp. A run has begun, or goes on out of DONE. */
void tumble_service_run_began(struct tumble_navcomp *navcomp);

#endif
