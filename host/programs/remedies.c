/* Written by tools/objects/generate from tools/objects/remedies.toml: change it there. */
#include "run_log.h"

/* clang-format off */
static const char *const remedies[TUMBLE_REASON_COUNT] = {
    [TUMBLE_REASON_NONE] = "Nothing is wrong.",
    [TUMBLE_REASON_COMMAND] = "Somebody gave ABORT, or the node was reset.",
    [TUMBLE_REASON_SCHEDULE] = "2004h:2 says how the schedule is wrong, as a number of tumble/status.h: positions missing that the estimator needs, or too few to determine all coefficients.",
    [TUMBLE_REASON_CONFIGURATION] = "A number of 2050h or of the board is out of range.",
    [TUMBLE_REASON_STAND_OFFLINE] = "No drive: power; on CAN node number 2, bit rate, termination; of a Modbus stand its address, port and unit.",
    [TUMBLE_REASON_STAND_HEARTBEAT] = "The drive fell silent for half a second: cable, power, bus load.",
    [TUMBLE_REASON_STAND_PROTOCOL] = "The drive refused an object of its profile, or does not follow it. 2004h:6 to 2004h:9 give object, abort code and step: see the drive's manual and docs/porting.md.",
    [TUMBLE_REASON_DRIVE_FAULT] = "2004h:3 is the drive's own error code. CLEAR_FAULT (8) or RESUME resets it.",
    [TUMBLE_REASON_DRIVE_POWER] = "Power stage off: emergency stop, enable input.",
    [TUMBLE_REASON_STALL] = "The axis does not follow: brake, obstacle, current limit.",
    [TUMBLE_REASON_HOMING] = "No home mark found within the cable's span and a turn: switch, direction, homing method. Or the position after it is neither 0 nor the home offset (607Ch), within 5 degrees: encoder, 607Ch. Unwind the cables by hand before RESUME: the next homing may turn as far again.",
    [TUMBLE_REASON_TARGET_NOT_REACHED] = "The drive was too slow or stopped short of the target: speed, gear, position window of the drive.",
    [TUMBLE_REASON_SLIP] = "The angle changed at rest, its reports jumped, or the mounting does not close (U9 against U1): clamp, brake, coupling, encoder cable, warm-up. On a schedule with inclinations also: the inclination, or the zero of the table angle, is 10 degrees or more off the schedule.",
    [TUMBLE_REASON_CABLE_LIMIT] = "A position cannot be reached within the cable's limits: schedule, approach, limits.",
    [TUMBLE_REASON_BLOCK_HEARTBEAT] = "The block fell silent: cable (it turns), power, node number 3.",
    [TUMBLE_REASON_NO_SAMPLES] = "The block has a heartbeat but sends no samples.",
    [TUMBLE_REASON_SAMPLES_LOST] = "Too many samples are missing: bus load, cable. 2032h counts them.",
    [TUMBLE_REASON_SAMPLES_CORRUPTED] = "Checksums fail: cable, termination, another sender on 683h or 693h.",
    [TUMBLE_REASON_BLOCK_STATUS] = "Self-test, converter or temperature range: the block itself.",
    [TUMBLE_REASON_SATURATED] = "A channel is at the end of its range: wiring, gain, a shock.",
    [TUMBLE_REASON_STUCK] = "A channel repeats one value: dead converter or channel.",
    [TUMBLE_REASON_NOT_STILL] = "More scatter than the declared noise: vibration, settling time too short, noise declared too small.",
    [TUMBLE_REASON_WARM_UP] = "The temperature is not stable: wait longer, shield the block from draught.",
    [TUMBLE_REASON_MOUNTING_NOT_CONFIRMED] = "Nobody confirmed in time. CONFIRM_MOUNTING continues.",
    [TUMBLE_REASON_WRONG_MOUNTING] = "By gravity, the block sits in another mounting or the stand is inclined differently: correct it, then confirm.",
    [TUMBLE_REASON_SWAPPED_CHANNELS] = "Gravity appears on the wrong channels or with the wrong sign: wiring, sign of the nominal scale.",
    [TUMBLE_REASON_SINGULAR] = "A dead channel or two parallel ones; with inclined: equal inclinations, or all on one side of level.",
    [TUMBLE_REASON_GRAVITY_CHECK] = "DONE, but the result fails the gravity check; see objection 0.",
    [TUMBLE_REASON_BUS] = "The computer's own controller is off the bus: bit rate, termination, short circuit.",
    [TUMBLE_REASON_UNCERTAIN] = "Even with all samples allowed, a mean is too noisy for its error budget.",
    [TUMBLE_REASON_INHIBITED] = "Board or host inhibit; START when it is over.",
    [TUMBLE_REASON_STOP_NOT_CONFIRMED] = "The table was commanded to stop, but nothing confirms that it did: look at it, use the emergency stop. 2035h shows how far the computer escalated (docs/bus/README.md).",
    [TUMBLE_REASON_FOREIGN_COMMAND] = "Another node commands the drive, or a second computer has node number 1: 1003h gives the identifier. Find it, then home again.",
    [TUMBLE_REASON_SUPERVISION] = "1016h or 1017h of node 1 is not as configured: it was written while there was no drive. Reset node 1 (NMT) to restore the board's values.",
    [TUMBLE_REASON_RUNAWAY] = "The table turned past its target, or in the wrong direction. Check cable and table before anything moves. Compare the profile's sign and wrap_counts with the drive, look for a second master (1003h) and for a drive that does not obey its set-point. RESUME homes again.",
    [TUMBLE_REASON_SCALE] = "The reported angle changes at a speed other than commanded. Compare the profile's counts_per_turn and velocity_per_deg_s with the drive, and the drive's own speed limit with speed_deg_s and the homing speeds. RESUME homes again.",
};
/* clang-format on */

const char *tumble_reason_remedy(tumble_reason_t reason)
{
    const unsigned index = (unsigned)reason;
    return (index < (unsigned)TUMBLE_REASON_COUNT) ? remedies[index] : "This reason is not in the list.";
}
