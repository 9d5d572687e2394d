"""Names that the client library calls things by. Written by tools/objects/generate from firmware lists,
the object tables and tools/objects/remedies.toml; not to be edited."""

# ruff: noqa: E501
# fmt: off

from __future__ import annotations

REASONS: tuple[tuple[str, str, str], ...] = (  # by number: name, meaning, what to do
    ("NONE", "nothing is wrong", "Nothing is wrong."),
    ("COMMAND", "aborted by command", "Somebody gave ABORT, or the node was reset."),
    ("SCHEDULE", "the schedule is not valid or cannot identify the coefficients", "2004h:2 says how the schedule is wrong, as a number of tumble/status.h: positions missing that the estimator needs, or too few to determine all coefficients."),
    ("CONFIGURATION", "the configuration is out of range", "A number of 2050h or of the board is out of range."),
    ("STAND_OFFLINE", "the stand did not come up", "No drive: power; on CAN node number 2, bit rate, termination; of a Modbus stand its address, port and unit."),
    ("STAND_HEARTBEAT", "the stand's heartbeat was lost", "The drive fell silent for half a second: cable, power, bus load."),
    ("STAND_PROTOCOL", "the stand refused its configuration or broke the handshake", "The drive refused an object of its profile, or does not follow it. 2004h:6 to 2004h:9 give object, abort code and step: see the drive's manual and docs/porting.md."),
    ("DRIVE_FAULT", "the drive reported a fault", "2004h:3 is the drive's own error code. CLEAR_FAULT (8) or RESUME resets it."),
    ("DRIVE_POWER", "the drive lost power or was switched off", "Power stage off: emergency stop, enable input."),
    ("STALL", "the axis did not follow its command", "The axis does not follow: brake, obstacle, current limit."),
    ("HOMING", "homing failed, took too long, turned too far or left a position that is not home", "No home mark found within the cable's span and a turn: switch, direction, homing method. Or the position after it is neither 0 nor the home offset (607Ch), within 5 degrees: encoder, 607Ch. Unwind the cables by hand before RESUME: the next homing may turn as far again."),
    ("TARGET_NOT_REACHED", "the table did not reach its target in time", "The drive was too slow or stopped short of the target: speed, gear, position window of the drive."),
    ("SLIP", "the table or the block left its position", "The angle changed at rest, its reports jumped, or the mounting does not close (U9 against U1): clamp, brake, coupling, encoder cable, warm-up. On a schedule with inclinations also: the inclination, or the zero of the table angle, is 10 degrees or more off the schedule."),
    ("CABLE_LIMIT", "the next position lies beyond the cable's limit", "A position cannot be reached within the cable's limits: schedule, approach, limits."),
    ("BLOCK_HEARTBEAT", "the accelerometer block's heartbeat was lost", "The block fell silent: cable (it turns), power, node number 3."),
    ("NO_SAMPLES", "no samples arrive from the block", "The block has a heartbeat but sends no samples."),
    ("SAMPLES_LOST", "too many samples were lost", "Too many samples are missing: bus load, cable. 2032h counts them."),
    ("SAMPLES_CORRUPTED", "too many corrupted frames from the block", "Checksums fail: cable, termination, another sender on 683h or 693h."),
    ("BLOCK_STATUS", "the block reports a fault of its own", "Self-test, converter or temperature range: the block itself."),
    ("SATURATED", "a channel is saturated", "A channel is at the end of its range: wiring, gain, a shock."),
    ("STUCK", "a channel repeats one value", "A channel repeats one value: dead converter or channel."),
    ("NOT_STILL", "the scatter exceeds the declared noise", "More scatter than the declared noise: vibration, settling time too short, noise declared too small."),
    ("WARM_UP", "the temperature did not settle in time", "The temperature is not stable: wait longer, shield the block from draught."),
    ("MOUNTING_NOT_CONFIRMED", "the operator did not confirm the mounting in time", "Nobody confirmed in time. CONFIRM_MOUNTING continues."),
    ("WRONG_MOUNTING", "gravity points another way: wrong mounting, or wrong inclination", "By gravity, the block sits in another mounting or the stand is inclined differently: correct it, then confirm."),
    ("SWAPPED_CHANNELS", "gravity appears on the wrong channels: channels are swapped or inverted", "Gravity appears on the wrong channels or with the wrong sign: wiring, sign of the nominal scale."),
    ("SINGULAR", "the coefficients found cannot be inverted", "A dead channel or two parallel ones; with inclined: equal inclinations, or all on one side of level."),
    ("GRAVITY_CHECK", "the result fails the gravity check", "DONE, but the result fails the gravity check; see objection 0."),
    ("BUS", "the CAN controller is off the bus", "The computer's own controller is off the bus: bit rate, termination, short circuit."),
    ("UNCERTAIN", "a mean is too noisy for its budget even with the most samples allowed", "Even with all samples allowed, a mean is too noisy for its error budget."),
    ("INHIBITED", "host or board does not allow a run now", "Board or host inhibit; START when it is over."),
    ("STOP_NOT_CONFIRMED", "the stop is not confirmed: check that the table is at rest", "The table was commanded to stop, but nothing confirms that it did: look at it, use the emergency stop. 2035h shows how far the computer escalated (docs/bus/README.md)."),
    ("FOREIGN_COMMAND", "another node commands the drive, or has this computer's number", "Another node commands the drive, or a second computer has node number 1: 1003h gives the identifier. Find it, then home again."),
    ("SUPERVISION", "heartbeats or process data do not monitor stand and block", "1016h or 1017h of node 1 is not as configured: it was written while there was no drive. Reset node 1 (NMT) to restore the board's values."),
    ("RUNAWAY", "the table passed its target or turned backwards", "The table turned past its target, or in the wrong direction. Check cable and table before anything moves. Compare the profile's sign and wrap_counts with the drive, look for a second master (1003h) and for a drive that does not obey its set-point. RESUME homes again."),
    ("SCALE", "the reported speed is not the commanded one: check counts per turn and units", "The reported angle changes at a speed other than commanded. Compare the profile's counts_per_turn and velocity_per_deg_s with the drive, and the drive's own speed limit with speed_deg_s and the homing speeds. RESUME homes again."),
)

COMMANDS: tuple[tuple[str, str], ...] = (  # by number: name, meaning
    ("NONE", "do nothing"),
    ("START", "begin a calibration"),
    ("ABORT", "stop the table and give up"),
    ("CONFIRM_MOUNTING", "the mounting with the number in the argument is on the table"),
    ("CONFIRM_ANGLE", "the dividing head stands at the angle asked for (operator stand only)"),
    ("REPEAT_POSITION", "measure the position at the index in the argument again"),
    ("REPEAT_MOUNTING", "measure the mounting with the number in the argument again"),
    ("RESUME", "go on after a fault has been mended"),
    ("CLEAR_FAULT", "reset the drive's fault"),
    ("ACCEPT", "make the proposal that is named the active set of coefficients"),
    ("DISCARD", "drop the proposal"),
    ("ROLLBACK", "go back to the set of coefficients before the active one"),
    ("HOME_AXIS", "home the table, between runs"),
    ("TURN_AXIS", "turn the table to the angle in the second argument, between runs"),
)

OBJECTIONS: tuple[tuple[str, str, str], ...] = (  # by number: name, meaning, what to do
    ("GRAVITY_CHECK", "the result fails the gravity check", "At some position the block does not feel 1 g: it moved, the table slipped, or the stand is worse than declared. 2022h gives the largest error. To find the position, record a run (tumble bench, or a CAN log) and give it to tumble solve. Repeat the calibration. Do not accept."),
    ("NOT_FINITE", "a number of the set is infinite or not a number, or a row of K is zero", "A fault of the block or of the software. Do not accept."),
    ("UNCERTAINTY_UNKNOWN", "the uncertainties are not known: the stand is not declared", "The board declares no stand. Declare one, or decide yourself each time."),
    ("UNCERTAIN", "a coefficient is less certain than its limit asks", "The uncertainty exceeds its limit. Take more samples, improve the stand, or widen the limit 2124h."),
    ("CHANGE", "a coefficient changed by more than drift and uncertainty explain", "A coefficient has changed by more than coverage x combined standard uncertainty + drift per month x months + drift per kelvin x kelvin. Months are limited to 1 to 24, so a clock that is years ahead does not allow more. Repeat the calibration. If the second result agrees with the first, the block has changed: accept. If not, the stand or the mounting has changed. Only this rule notices a rotation common to all axes."),
    ("OTHER_BLOCK", "the active set is of a block with another serial number", "The serial number on the board differs from that of the active set. If you replaced the block, accept."),
    ("FIRST", "there is no active set to compare with", "There is no earlier set to compare with. Check the result, then accept."),
    ("OLDER", "it is dated before the active set: the clock is wrong or the run is an old one", "The result is dated before the active set. Set the clock (2121h:1) and repeat; otherwise an old run is being replayed. An active set dated in the future counts as undated: it does not raise this objection, and sets 2120h:9 bit 3."),
    ("REPLAYED", "the same coefficients, to the last bit, were found before: the run is not new", "Nothing is stored. Noise makes every run different, but this one equals an earlier one: the samples were replayed, not measured, or the same run was offered twice after a loss of power."),
    ("LIMITS", "a limit of these rules is out of its range", "A setting in 2123h to 2126h is out of range."),
    ("BY_HAND", "every set is to be accepted by an operator", "2123h:2 bit 0 is not set: an operator decides about every set."),
    ("OTHER_RULES", "the rules were changed from the board's", "The gravity limit or the commit rules were changed at service level and not saved. Switch power off and on to restore the saved ones, and repeat; or save the new ones (1010h)."),
    ("DOES_NOT_FIT", "the means scatter by more than the declared stand and noise explain", "The means of a mounting scatter by more than the declared stand and noise explain (docs/method.md, \"Does the run fit its stand?\"): the outputs stepped or drifted, the table slipped, or the stand is worse than declared. Repeat. If every run raises it, declare the stand as it is (set angles, noise). Do not accept without finding the cause. A position repeated after re-mounting the block has a different yaw from its neighbours and raises it too: repeat the mounting (6) instead. A sound run raises it in less than one case in a thousand."),
    ("WHOLE_MODEL", "twelve coefficients and the declared stand do not explain the run as a whole", "Twelve coefficients and the declared stand do not explain the run as a whole, including the differences between mountings: the outputs drifted, the block is not linear, or the stand is worse than declared. 2025h says by how much. Only boards with this test raise it; they raise 12 too if a single mounting shows the misfit. Repeat. If every run raises it, record one (tumble bench, or a CAN log): tumble solve names what explains it. Do not accept without finding the cause. One sound run in a thousand raises it."),
    ("DISTURBED", "too many samples or position reports were lost, refused or not believed", "More than one in 20 samples of the run was lost, corrupted, repeated or out of order (2032h), or as many position reports were implausible (2035h:6): bus wiring or termination is bad, another node sends with identifiers of the block or of the drive, or the block was off the bus for some seconds. Repair that, and repeat."),
    ("NEWER_SET", "the memory holds a set of a newer version, which this one would replace", "The memory holds a set written by a newer version of the firmware, so the firmware was downgraded. Upgrade again to use that set. To stay with this version, accept: a new set may then overwrite the newer one."),
    ("NOT_SHOWN", "three u(|a|) exceed the gravity limit at some attitude: it is not shown to be met", "Measured positions and fit are good, but three standard uncertainties of the length of the specific force exceed the gravity limit at some attitude (docs/method.md). Bit 0 of 2120h:15, not in 2120h:6, which is full. tumble plan require with the declared stand says what would show it: more samples, the estimator optimal, a third mounting, a better stand. Do not accept until it is shown."),
    ("TEMPERATURE", "the temperature is not known, or outside the range of the active set's slopes", "The active set has slopes (docs/embedding.md), and the run's temperature is not known or outside the range in which they hold, so the run cannot update them. Bit 1 of 2120h:15. Repeat within the range. Accepting replaces the slopes by coefficients of one temperature."),
)

VERDICTS: tuple[tuple[str, str], ...] = (  # by number: name, meaning
    ("NONE", "nothing yet since power-on"),
    ("WORKING", "not decided or not written yet"),
    ("COMMITTED", "the result is the active set"),
    ("HELD", "it is the proposal; see objections"),
    ("REPEATED", "it is one that the store has held before: nothing was written"),
    ("ACCEPTED", "the proposal is the active set"),
    ("DISCARDED", "the proposal is gone"),
    ("ROLLED_BACK", "the set before is active again"),
    ("FAILED", "the memory failed; see status"),
)

STAND_STEPS: dict[int, str] = {  # of 2004h:9: what the drive was asked for
    0: "first contact",
    1: "configuration",
    2: "the first process data after NMT start",
    3: "the way up to Operation enabled",
    5: "the change to homing mode",
    6: "homing",
    7: "the change to profile position mode",
    8: "the target, before the set-point",
    9: "the set-point: bit 12 after bit 4 was set",
    10: "the set-point: bit 12 after bit 4 was cleared",
    11: "the motion",
    12: "what a motion depends on, read back before it",
}

SETTINGS: dict[str, tuple[str, ...]] = {  # by object: which of them need the service level
    "Configuration": ("Gravity limit",),
    "Host": (),
    "Recalibration": ("Flags",),
    "Commit rules": ("Coverage", "Flags",),
    "Uncertainty limits": ("K_xx", "K_xy", "K_xz", "K_yx", "K_yy", "K_yz", "K_zx", "K_zy", "K_zz", "U0_x", "U0_y", "U0_z",),
    "Drift limits per month": ("K_xx", "K_xy", "K_xz", "K_yx", "K_yy", "K_yz", "K_zx", "K_zy", "K_zz", "U0_x", "U0_y", "U0_z",),
    "Drift limits per kelvin": ("K_xx", "K_xy", "K_xz", "K_yx", "K_yy", "K_yz", "K_zx", "K_zy", "K_zz", "U0_x", "U0_y", "U0_z",),
}
