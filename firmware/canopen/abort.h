/* abort.h - SDO abort codes (CiA 301, table 22), the reason that an access to an object is refused.
 *
 * 0 means "not refused". Dictionary functions and write hooks return these numbers as they travel on the bus. All of
 * them fit an int, so they can be an enum; a code received from another node is kept as a plain number.
 */
#ifndef TUMBLE_CANOPEN_ABORT_H
#define TUMBLE_CANOPEN_ABORT_H

#include <stdint.h>

#define TUMBLE_ABORT_LIST(X)                                                                                           \
    X(TUMBLE_ABORT_NONE, 0x00000000, "not aborted")                                                                    \
    X(TUMBLE_ABORT_LATER, 0x00000001, "the answer is not known yet") /* never on the bus: see sdo.h */                 \
    X(TUMBLE_ABORT_TOGGLE, 0x05030000, "toggle bit did not alternate")                                                 \
    X(TUMBLE_ABORT_TIMEOUT, 0x05040000, "SDO protocol timed out")                                                      \
    X(TUMBLE_ABORT_COMMAND, 0x05040001, "command specifier unknown or not valid here")                                 \
    X(TUMBLE_ABORT_MEMORY, 0x05040005, "out of memory")                                                                \
    X(TUMBLE_ABORT_ACCESS, 0x06010000, "unsupported access to an object")                                              \
    X(TUMBLE_ABORT_WRITE_ONLY, 0x06010001, "attempt to read a write-only object")                                      \
    X(TUMBLE_ABORT_READ_ONLY, 0x06010002, "attempt to write a read-only object")                                       \
    X(TUMBLE_ABORT_NO_OBJECT, 0x06020000, "object does not exist")                                                     \
    X(TUMBLE_ABORT_NOT_MAPPABLE, 0x06040041, "object cannot be mapped to this PDO")                                    \
    X(TUMBLE_ABORT_MAP_LENGTH, 0x06040042, "mapped objects would exceed the PDO's length")                             \
    X(TUMBLE_ABORT_INCOMPATIBLE, 0x06040043, "parameters are incompatible with each other")                            \
    X(TUMBLE_ABORT_HARDWARE, 0x06060000, "access failed because of a hardware error")                                  \
    X(TUMBLE_ABORT_LENGTH, 0x06070010, "data type or length does not match")                                           \
    X(TUMBLE_ABORT_TOO_LONG, 0x06070012, "value is too long for the object")                                           \
    X(TUMBLE_ABORT_TOO_SHORT, 0x06070013, "value is too short for the object")                                         \
    X(TUMBLE_ABORT_NO_SUBINDEX, 0x06090011, "subindex does not exist")                                                 \
    X(TUMBLE_ABORT_VALUE, 0x06090030, "value is not allowed for this object")                                          \
    X(TUMBLE_ABORT_TOO_HIGH, 0x06090031, "value is too high")                                                          \
    X(TUMBLE_ABORT_TOO_LOW, 0x06090032, "value is too low")                                                            \
    X(TUMBLE_ABORT_GENERAL, 0x08000000, "general error")                                                               \
    X(TUMBLE_ABORT_STORE, 0x08000020, "data cannot be transferred or stored")                                          \
    X(TUMBLE_ABORT_LOCAL_CONTROL, 0x08000021, "refused because of local control")                                      \
    X(TUMBLE_ABORT_DEVICE_STATE, 0x08000022, "refused in the present state of the device")                             \
    X(TUMBLE_ABORT_NO_DATA, 0x08000024, "no data available")

typedef enum {
#define TUMBLE_ABORT_ENUM(name, code, sentence) name = (code),
    TUMBLE_ABORT_LIST(TUMBLE_ABORT_ENUM)
#undef TUMBLE_ABORT_ENUM
} tumble_abort_t;

/* One sentence for a person, without full stop; "this abort code is not in the list" for others (other servers know
 * more of them). Never null. */
const char *tumble_abort_sentence(uint32_t code);

#endif
