/* Written by tools/objects/generate from tools/objects/remedies.toml: change it there. */
#include "run_log.h"

/* clang-format off */
static const char *const remedies[TUMBLE_REASON_COUNT] = {
    [TUMBLE_REASON_NONE] = "Nothing is wrong.",
    [TUMBLE_REASON_COMMAND] = "Somebody gave ABORT, or the node was reset.",
    [TUMBLE_REASON_SCHEDULE] = "2004h:2 says how the schedule is wrong, as a number of tumble/status.h: positions missing that the estimator needs, or too few to tell all coefficients.",
    [TUMBLE_REASON_CONFIGURATION] = "A number of 2050h or of the board is out of range.",
    [TUMBLE_REASON_STAND_OFFLINE] = "No drive: power; on CAN node number 2, bit rate, termination; of a Modbus stand its address, port and unit.",
    [TUMBLE_REASON_STAND_HEARTBEAT] = "The drive fell silent for half a second: cable, power, bus load.",
    [TUMBLE_REASON_STAND_PROTOCOL] = "The drive refused an object of its profile, or does not keep to it. 2004h:6 to 2004h:9 name object, abort code and step: the drive's manual, and docs/porting.md.",
    [TUMBLE_REASON_DRIVE_FAULT] = "2004h:3 is the drive's own error code. CLEAR_FAULT (8) or RESUME resets it.",
    [TUMBLE_REASON_DRIVE_POWER] = "Power stage off: emergency stop, enable input.",
    [TUMBLE_REASON_STALL] = "The axis does not follow: brake, obstacle, current limit.",
    [TUMBLE_REASON_HOMING] = "No home mark found within the cable's span and a turn: switch, direction, homing method. Or the position after it is neither 0 nor the home offset (607Ch), within 5 degrees: encoder, 607Ch. Unwind the cables by hand before RESUME: the next homing may turn as far again.",
    [TUMBLE_REASON_TARGET_NOT_REACHED] = "Too slow or short of it: speed, gear, window of the drive.",
    [TUMBLE_REASON_SLIP] = "The angle changed at rest, its reports jumped, or the mounting does not close (U9 against U1): clamp, brake, coupling, encoder cable, warm-up. On a schedule with inclinations also: the inclination, or the zero of the table angle, is 10 degrees or more from the schedule's.",
    [TUMBLE_REASON_CABLE_LIMIT] = "A position cannot be reached within the cable's limits: schedule, approach, limits.",
    [TUMBLE_REASON_BLOCK_HEARTBEAT] = "The block fell silent: cable (it turns), power, node number 3.",
    [TUMBLE_REASON_NO_SAMPLES] = "It lives but sends no samples.",
    [TUMBLE_REASON_SAMPLES_LOST] = "More than allowed are missing: bus load, cable. 2032h counts.",
    [TUMBLE_REASON_SAMPLES_CORRUPTED] = "Checksums fail: cable, termination, somebody else on 683h or 693h.",
    [TUMBLE_REASON_BLOCK_STATUS] = "Self-test, converter or temperature range: the block itself.",
    [TUMBLE_REASON_SATURATED] = "A channel at the end of its range: wiring, gain, a shock.",
    [TUMBLE_REASON_STUCK] = "A channel repeats one value: dead converter or channel.",
    [TUMBLE_REASON_NOT_STILL] = "More scatter than the declared noise: vibration, settling time too short, noise declared too small.",
    [TUMBLE_REASON_WARM_UP] = "The temperature does not hold still: wait longer, shield from draught.",
    [TUMBLE_REASON_MOUNTING_NOT_CONFIRMED] = "Nobody confirmed in time. CONFIRM_MOUNTING goes on.",
    [TUMBLE_REASON_WRONG_MOUNTING] = "Gravity says that the block sits in another mounting, or that the stand leans another way: mount or incline it rightly, confirm.",
    [TUMBLE_REASON_SWAPPED_CHANNELS] = "Gravity on the wrong channels, or with the wrong sign: wiring, sign of the nominal scale.",
    [TUMBLE_REASON_SINGULAR] = "A dead channel or two parallel ones; with inclined: inclinations alike, or all on one side of the level.",
    [TUMBLE_REASON_GRAVITY_CHECK] = "DONE, but the result fails the gravity check; see objection 0.",
    [TUMBLE_REASON_BUS] = "The computer's own controller is off the bus: bit rate, termination, short circuit.",
    [TUMBLE_REASON_UNCERTAIN] = "Too noisy for the error budget of a mean with all samples allowed.",
    [TUMBLE_REASON_INHIBITED] = "Board or host inhibit; START when it is over.",
    [TUMBLE_REASON_STOP_NOT_CONFIRMED] = "The table was told to stop and was not seen to: look at it, use the emergency stop. 2035h says how far the computer went (docs/bus/README.md).",
    [TUMBLE_REASON_FOREIGN_COMMAND] = "Somebody else commands the drive, or a second computer has node number 1: 1003h names the identifier. Find it, then home again.",
    [TUMBLE_REASON_SUPERVISION] = "1016h or 1017h of node 1 is not as configured; somebody wrote it while there was no drive. Reset node 1 (NMT): they are the board's again.",
    [TUMBLE_REASON_RUNAWAY] = "The table turned past its goal, or the other way. Look at cable and table before anything moves. Compare the profile's sign and wrap_counts with the drive, look for a second master (1003h) and for a drive that does not obey its set-point. RESUME homes again.",
    [TUMBLE_REASON_SCALE] = "The reported angle changes at another speed than the drive was told. Compare the profile's counts_per_turn and velocity_per_deg_s with the drive, and the drive's own limit of speed with speed_deg_s and the homing speeds. RESUME homes again.",
};
/* clang-format on */

const char *tumble_reason_remedy(tumble_reason_t reason)
{
    const unsigned index = (unsigned)reason;
    return (index < (unsigned)TUMBLE_REASON_COUNT) ? remedies[index] : "This reason is not in the list.";
}
