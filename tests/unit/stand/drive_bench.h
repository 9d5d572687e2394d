/* drive_bench.h - a drive402 on a node of its own, and the scripted drive at the other end of its port. */
#ifndef TUMBLE_TESTS_UNIT_DRIVE_BENCH_H
#define TUMBLE_TESTS_UNIT_DRIVE_BENCH_H

#include "scripted_drive.h"
#include "stand/drive402/drive402.h"
#include "support.h"

typedef struct {
    tumble_node_t node;
    tumble_drive_mirror_t mirror;
    tumble_drive402_t drive;
    tumble_stand_t stand;
} drive_bench_t;

extern drive_bench_t bench;
extern scripted_drive_t played;
extern fake_port_t port;
extern tumble_drive_profile_t made; /* one that a case has made */

/* Its address: that profile, and what is changed in it. */
#define MADE(profile) (made = (profile), &made)
#define CHANGED(base, ...) (made = (base), __VA_ARGS__, &made)
extern const tumble_node_config_t own_config; /* of the node */

/* A millisecond of both. */
void run_ms(unsigned ms);

tumble_stand_state_t stand_state(void);

/* Until the stand is in this state; fails after so many milliseconds. */
void run_to(tumble_stand_state_t state, unsigned most_ms);

/* The drive's, with a cable from -30 to 400 degrees. */
tumble_status_t drive_init(const tumble_drive_profile_t *profile, uint8_t drive_node);

/* The drive comes, until it is ready; then it is homed. */
void boot_drive(void);
void go_home(void);

/* With nobody there; with the drive ready; with it homed. */
void bench_setup(const tumble_drive_profile_t *profile);
void bring_up(const tumble_drive_profile_t *profile);
void bring_home(const tumble_drive_profile_t *profile);

/* Our computer begins anew, with the common profile, and the drive has not noticed. */
void restart_computer(void);

void assert_state_after(unsigned ms, tumble_stand_state_t state);
void assert_fault(tumble_stand_fault_t fault);
void assert_fault_after(unsigned ms, tumble_stand_fault_t fault);
void run_to_fault(tumble_stand_fault_t fault, unsigned most_ms);
void assert_angle(double expected_deg);

/* What the drive refused to be brought to: a fault of the protocol. */
void assert_refused(uint16_t index, uint8_t subindex, tumble_stand_step_t step, uint32_t abort);

/* An order that is taken, and then so many milliseconds; a move until it is there. */
void move_for(unsigned ms, double angle_deg);
void home_for(unsigned ms);
void stop_for(unsigned ms);
void move_to(double angle_deg);

/* What the drive does, and then so many milliseconds. */
void drive_boots(unsigned ms);
void drive_fails(uint16_t code, unsigned ms);

/* Homed, and on its way to 90 degrees. */
void start_move(const tumble_drive_profile_t *profile);

/* As soon as the axis has been seen at rest, or nothing is left to be tried. */
void clear_fault(void);
void recover(tumble_stand_state_t state); /* and get into this one */

void stop_at_rest(void);
void report_now(void); /* the drive reports, and is heard */

/* The common drive: 36,000 counts a turn, one PDO each way. */
extern const tumble_drive_pdo_t common_receive[];
extern const tumble_drive_pdo_t common_transmit[];
extern const tumble_drive_profile_t common;

/* The common drive, stopped by Halt; and one whose position counts modulo a turn. */
tumble_drive_profile_t halting(void);
tumble_drive_profile_t wrapping(void);

#endif
