/* commissioning.h - what a board is told about its stand and block when it is put into service: a record of bytes in
 * memory that outlives power, in the place of the built-in configuration.
 *
 * The record, the same on every machine, all little endian: "TUMBLECF"; length of what follows the header, uint32;
 * checksum of it (FNV-1a, 32 bits); then the fields, lists and schedule in the order of commissioning.c and of the tables of
 * fields (procedure/config_fields.h), real numbers as in IEEE 754.
 */
#ifndef ZCU102_COMMISSIONING_H
#define ZCU102_COMMISSIONING_H

#include "stand/drive402/drive402.h"
#include "tumble/navcomp.h"

#include <stddef.h>
#include <stdint.h>

#define ZCU102_COMMISSIONING_BYTES 8192U /* room for the largest */
#define ZCU102_MAX_WRITES 16U
#define ZCU102_MAX_MOUNTINGS 6U

typedef struct {
    tumble_averaging_config_t averaging;
    tumble_procedure_config_t procedure;
    tumble_drive_profile_t drive;
    uint32_t block_period_us;
    uint16_t heartbeat_ms;
    uint16_t heartbeat_timeout_ms;
    tumble_schedule_t schedule; /* what the pointers above point at: */
    tumble_mounting_t mountings[ZCU102_MAX_MOUNTINGS];
    tumble_position_t positions[TUMBLE_MAX_POSITIONS];
    tumble_drive_pdo_t receive[TUMBLE_DRIVE402_PDOS];
    tumble_drive_pdo_t transmit[TUMBLE_DRIVE402_PDOS];
    tumble_object_write_t writes[ZCU102_MAX_WRITES];
} zcu102_commissioned_t;

/* Gather a configuration, following its pointers. Returns TUMBLE_OK, or TUMBLE_E_ARGUMENT: no drive, or more PDOs,
 * writes, mountings or positions than fit. */
tumble_status_t zcu102_commission(zcu102_commissioned_t *to, const tumble_navcomp_config_t *config);

/* Write a record. Returns its size. */
size_t zcu102_commissioning_write(zcu102_commissioned_t *from, uint8_t record[ZCU102_COMMISSIONING_BYTES]);

/* Read a record; all pointers are set within `to`, which must not be moved. Returns TUMBLE_OK; TUMBLE_E_PORT_EMPTY:
 * there is none; TUMBLE_E_CRC: it is spoilt. Whether the numbers make sense is asked when the firmware starts. */
tumble_status_t zcu102_commissioning_read(zcu102_commissioned_t *to, const uint8_t record[ZCU102_COMMISSIONING_BYTES]);

#endif
