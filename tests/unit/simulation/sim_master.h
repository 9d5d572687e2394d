/* sim_master.h - a plain CiA 402 master for tests of the simulated drive: sends frames, keeps what comes back.
 *
 * It shares nothing with the firmware's master. Every call lets virtual time pass; SDO calls wait for the answer.
 */
#ifndef TUMBLE_TESTS_UNIT_SIM_MASTER_H
#define TUMBLE_TESTS_UNIT_SIM_MASTER_H

#include "simulation/drive.h"
#include "support.h"

#include <string.h>

enum { MASTER_BUS_NODE = 0, DRIVE_BUS_NODE = 1 };

extern sim_clock_t virtual_clock;
extern sim_wire_t wire;
extern sim_bus_t bus;
extern sim_scenario_t scenario;
extern sim_angle_error_t angle_error;
extern sim_drive_t drive;

/* What has come from the drive. */
typedef struct {
    uint16_t statusword;
    int32_t position;
    uint32_t status_frames;
    uint32_t position_frames;
    uint16_t emergency; /* last error code */
    uint32_t emergencies;
    uint8_t answer[8]; /* of the last SDO */
    bool answered;
    uint8_t nmt_state;
} heard_t;

extern heard_t heard;

extern bool beating; /* does the master send its heartbeat? */

void pass_until(uint64_t limit_us);
void pass_ms(uint32_t ms);
void expect_status_after(uint32_t ms, uint16_t expected, uint16_t mask); /* what the statusword has of these bits */
void send_frame(uint16_t id, uint8_t length, const uint8_t *data);
void nmt(uint8_t command);

/* Abort code, 0 when it was written. */
uint32_t sdo_write(uint16_t index, uint8_t subindex, uint32_t value, uint8_t size);

uint32_t sdo_read(uint16_t index, uint8_t subindex);

/* Receive PDO 1: controlword and target. */
void command(uint16_t controlword, int32_t target);
void command_for(uint32_t ms, uint16_t controlword, int32_t target); /* and let so long pass */

/* A fresh drive at 10 degrees, master beating, drive booted. The scenario may be changed before. */
void power_on(void);

/* PDOs mapped, Operational, watching our heartbeat. */
void configure(void);

void enable(void);

/* Homed, in profile position mode, at rest at 0. */
void home(void);
void enable_and_home(void);

/* The set-point handshake as it should be: target first, then the edge, until it is taken; then bit 4 down. */
void set_target(int32_t target);
void target_for(uint32_t ms, int32_t target);

#endif
