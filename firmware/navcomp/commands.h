/* commands.h - what the navigation computer can be told to do, by its host and over CAN.
 *
 * The numbers travel over CAN (command object) and Modbus: new ones go to the end.
 */
#ifndef TUMBLE_NAVCOMP_COMMANDS_H
#define TUMBLE_NAVCOMP_COMMANDS_H

#define TUMBLE_COMMAND_LIST(X)                                                                                         \
    X(TUMBLE_COMMAND_NONE, "do nothing")                                                                               \
    X(TUMBLE_COMMAND_START, "begin a calibration")                                                                     \
    X(TUMBLE_COMMAND_ABORT, "stop the table and give up")                                                              \
    X(TUMBLE_COMMAND_CONFIRM_MOUNTING, "the mounting with the number in the argument is on the table")                 \
    X(TUMBLE_COMMAND_CONFIRM_ANGLE, "the dividing head stands at the angle asked for (operator stand only)")           \
    X(TUMBLE_COMMAND_REPEAT_POSITION, "measure the position at the index in the argument again")                       \
    X(TUMBLE_COMMAND_REPEAT_MOUNTING, "measure the mounting with the number in the argument again")                    \
    X(TUMBLE_COMMAND_RESUME, "go on after a fault has been mended")                                                    \
    X(TUMBLE_COMMAND_CLEAR_FAULT, "reset the drive's fault")                                                           \
    X(TUMBLE_COMMAND_ACCEPT, "make the proposal that is named the active set of coefficients")                         \
    X(TUMBLE_COMMAND_DISCARD, "drop the proposal")                                                                     \
    X(TUMBLE_COMMAND_ROLLBACK, "go back to the set of coefficients before the active one")                             \
    X(TUMBLE_COMMAND_HOME_AXIS, "home the table, between runs")                                                        \
    X(TUMBLE_COMMAND_TURN_AXIS, "turn the table to the angle in the second argument, between runs")

typedef enum {
#define TUMBLE_COMMAND_ENUM(name, sentence) name,
    TUMBLE_COMMAND_LIST(TUMBLE_COMMAND_ENUM)
#undef TUMBLE_COMMAND_ENUM
        TUMBLE_COMMAND_COUNT
} tumble_command_t;

/* Name ("TUMBLE_COMMAND_START"); safe for values outside the list, never null. */
const char *tumble_command_name(tumble_command_t command);

#endif
