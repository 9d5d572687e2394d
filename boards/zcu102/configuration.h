/* configuration.h - what this board is told about its stand, its block and its bus. Built in: navcomp/standard.h. A
 * commissioning record takes its place. What differs from run to run can be written over CAN (2050h).
 */
#ifndef ZCU102_CONFIGURATION_H
#define ZCU102_CONFIGURATION_H

#include "can.h"
#include "commissioning.h"
#include "tumble/navcomp.h"

/* Where a commissioning record lies: in the emulator, memory that its loader fills. The chip has its flash for that,
 * once a board has one mapped: until then what is built in counts. */
#ifdef ZCU102_EMULATED
#define ZCU102_COMMISSIONING_ADDRESS 0x1800000U
#endif

/* The configuration in force, without port, hooks and the memory of its stand, a drive: that of the record, read into `room`, or what is built in.
 * Returns TUMBLE_OK, or TUMBLE_E_CRC: the record is spoilt. */
tumble_status_t zcu102_configure(tumble_navcomp_config_t *config, zcu102_commissioned_t *room);

/* The first controller, hearing only what node 1 listens to. */
extern const zcu102_can_config_t zcu102_can;

/* The same, but open to everything where the drive's process data would not pass the filters. */
zcu102_can_config_t zcu102_can_for(const tumble_navcomp_config_t *config);

#endif
