/* scripted_drive.h - a CiA 402 drive as a script: enough of one to be configured, homed, moved and made to fail.
 *
 * It takes any SDO write, keeps the mode, moves at constant speed, and reports on change and every 20 ms. What drives
 * do wrong is tested elsewhere; here the drive behaves, until a test tells it not to.
 */
#ifndef TUMBLE_TESTS_SCRIPTED_DRIVE_H
#define TUMBLE_TESTS_SCRIPTED_DRIVE_H

#include "core/bytes.h"
#include "canopen/cia402.h"
#include "canopen/emcy.h"
#include "canopen/nmt.h"
#include "canopen/sdo.h"
#include "fake_port.h"
#include "stand/drive402/drive402.h"

#include <stdbool.h>
#include <stdint.h>

#define SCRIPTED_DRIVE_NODE 2U
#define SCRIPTED_COUNTS_PER_REVOLUTION 360000
#define SCRIPTED_MOVE_US 200000U /* of any move */
#define SCRIPTED_REPORT_US 20000U

typedef struct {
    uint64_t next_heartbeat_us;
    uint64_t next_report_us;
    uint64_t arrival_us; /* UINT64_MAX: at rest */
    int32_t start_counts;
    int32_t position_counts;
    int32_t goal_counts;
    int32_t target_counts; /* 607Ah */
    uint32_t writes;       /* SDO downloads */
    uint16_t controlword;
    uint16_t power; /* TUMBLE_402_STATE_... */
    uint16_t flags; /* statusword bits of the mode */
    uint16_t reported;
    uint16_t refused_index; /* an object whose writing is refused; 0: none */
    int8_t mode;
    uint8_t nmt;
    bool homing;
    bool dead;
    bool jammed; /* sets out and never arrives */
} scripted_drive_t;

void scripted_drive_boot(scripted_drive_t *drive, fake_port_t *fake);
void scripted_drive_init(scripted_drive_t *drive, fake_port_t *fake);
bool scripted_drive_moves(const scripted_drive_t *drive);
double scripted_drive_angle_deg(const scripted_drive_t *drive);
void scripted_drive_hear(scripted_drive_t *drive, fake_port_t *fake, const tumble_can_frame_t *frame);

/* A fault of its own: the axis stops, an emergency message tells the code. */
void scripted_drive_fail(scripted_drive_t *drive, fake_port_t *fake, uint16_t code);

void scripted_drive_step(scripted_drive_t *drive, fake_port_t *fake);
uint64_t scripted_drive_next_us(const scripted_drive_t *drive);

/* The profile that fits it. */
extern const tumble_drive_profile_t scripted_drive_profile;

#endif
