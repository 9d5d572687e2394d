/* profile_fields.h - every number of tumble_drive_profile_t (drive402.h), a row each: procedure/config_fields.h tells
 * how. Here `signs` is only for readers: profile.c has the checks, because most of them are relations. The lists of
 * PDOs and writes are not fields.
 */
#ifndef TUMBLE_STAND_DRIVE402_PROFILE_FIELDS_H
#define TUMBLE_STAND_DRIVE402_PROFILE_FIELDS_H

/* clang-format off */
#define TUMBLE_DRIVE_FIELDS(X)                                                                                         \
    X(F64, counts_per_revolution, 360000.0, POSITIVE, RESULT, 1, "profile.counts_per_turn", 0, 1e12,                   \
      "counts of 6064h and 607Ah per turn of the table, gears included; 0: drive.counts_per_turn")                     \
    X(I8, sign, 1, ANY, RESULT, 3, "profile.sign", -1, 1,                                                              \
      "1, or -1: counts fall when the table turns upwards; 0: drive.sign, and the wrap is drive.wrap_counts")          \
    X(U32, wrap_counts, 0U, ANY, NO_RESULT, 2, "profile.wrap_counts", 0, INT32_MAX,                                    \
      "6064h and 607Ah count modulo this, given with profile.sign; 0: they do not wrap")                               \
    X(F64, velocity_units_per_deg_s, 1000.0, POSITIVE, NO_RESULT, 1, "profile.velocity_per_deg_s", 0, 1e9,             \
      "units of 6081h and 6099h per deg/s of the table; 0: drive.velocity_per_deg_s")                                  \
    X(F64, acceleration_units_per_deg_s2, 1000.0, POSITIVE, NO_RESULT, 1, "profile.acceleration_per_deg_s2", 0, 1e9,   \
      "units of 6083h to 6085h and 609Ah per deg/s2; 0: drive.acceleration_per_deg_s2")                                \
    X(U32, window_counts, 0U, ANY, NO_RESULT, 2, "profile.window_counts", 0, UINT32_MAX,                               \
      "target reached is believed within so many counts of the target; 0: always")                                     \
    X(F64, velocity_deg_s, 90.0, ANY, NO_RESULT, 1, "profile.speed_deg_s", 0, 1e4,                                     \
      "deg/s; 6081h; 0: motion.speed_deg_s")                                                                           \
    X(F64, acceleration_deg_s2, 180.0, ANY, NO_RESULT, 1, "profile.acceleration_deg_s2", 0, 1e5,                       \
      "deg/s2; 6083h; 0: motion.acceleration_deg_s2")                                                                  \
    X(F64, deceleration_deg_s2, 180.0, ANY, NO_RESULT, 1, "profile.deceleration_deg_s2", 0, 1e5,                       \
      "deg/s2; 6084h; unless given the acceleration; 0: not written")                                                  \
    X(F64, quick_stop_deg_s2, 180.0, ANY, NO_RESULT, 1, "profile.quick_stop_deg_s2", 0, 1e5,                           \
      "deg/s2; 6085h; unless given the acceleration; 0: not written")                                                  \
    X(F64, homing_fast_deg_s, 45.0, ANY, NO_RESULT, 1, "profile.homing_fast_deg_s", 0, 1e4,                            \
      "deg/s; 6099h:1; 0: not written")                                                                                \
    X(F64, homing_slow_deg_s, 4.5, ANY, NO_RESULT, 1, "profile.homing_slow_deg_s", 0, 1e4,                             \
      "deg/s; 6099h:2; 0: not written")                                                                                \
    X(F64, homing_acceleration_deg_s2, 180.0, ANY, NO_RESULT, 1, "profile.homing_acceleration_deg_s2", 0, 1e5,         \
      "deg/s2; 609Ah; unless given the acceleration; 0: not written")                                                  \
    X(F64, homing_travel_deg, 0.0, NOT_NEGATIVE, NO_RESULT, 5, "profile.homing_travel_deg", 0, 1e5,                    \
      "deg; the table may turn so far in homing; 0: the cable's span and one turn")                                    \
    X(BOOL, software_limits, true, ANY, NO_RESULT, 5, "profile.software_limits", 0, 0,                                 \
      "write the cable's limits to 607Dh, and read them back")                                                         \
    X(I8, homing_method, 34, ANY, RESULT, 3, "profile.homing_method", INT8_MIN, INT8_MAX, "6098h; 0: not written")     \
    X(ENUM8, stop, TUMBLE_STOP_BY_QUICK_STOP, ANY, NO_RESULT, 3, "profile.stop", 0, 0, "quick_stop|halt")              \
    X(U16, heartbeat_ms, 100U, ANY, NO_RESULT, 4, "profile.heartbeat_ms", 0, UINT16_MAX,                               \
      "ms; 1017h; 0: not written, it sends a heartbeat by itself")                                                     \
    X(U16, heartbeat_timeout_ms, 500U, ANY, NO_RESULT, 4, "profile.heartbeat_timeout_ms", 0, UINT16_MAX,               \
      "ms; 1016h:1, our silence after which it stops; 0: not written")                                                 \
    X(U32, start_timeout_ms, 3000U, POSITIVE, NO_RESULT, 2, "profile.start_timeout_ms", 1, UINT32_MAX,                 \
      "ms; NMT start to its first process data")                                                                       \
    X(U32, power_timeout_ms, 3000U, POSITIVE, NO_RESULT, 2, "profile.power_timeout_ms", 1, UINT32_MAX,                 \
      "ms; from there to Operation enabled")                                                                           \
    X(U32, handshake_timeout_ms, 1000U, POSITIVE, NO_RESULT, 2, "profile.handshake_timeout_ms", 1, UINT32_MAX,         \
      "ms; a change of mode, bit 12 after a set-point")                                                                \
    X(U32, home_timeout_ms, 60000U, POSITIVE, NO_RESULT, 2, "profile.home_timeout_ms", 1, UINT32_MAX, "ms; homing")    \
    X(U32, move_timeout_ms, 30000U, POSITIVE, NO_RESULT, 2, "profile.move_timeout_ms", 1, UINT32_MAX, "ms; a move")    \
    X(U32, stop_timeout_ms, 5000U, POSITIVE, NO_RESULT, 2, "profile.stop_timeout_ms", 1, UINT32_MAX,                   \
      "ms; braking, once it obeys")                                                                                    \
    X(BOOL, keeps_pdos, false, ANY, NO_RESULT, 6, "profile.keeps_pdos", 0, 0,                                          \
      "its PDOs cannot be written: they are read, and must be as given")                                               \
    X(BOOL, acknowledges_enabling, false, ANY, NO_RESULT, 6, "profile.acknowledges_enabling", 0, 0,                    \
      "bit 12 is set from Operation enabled on; its first set-point clears it")
/* clang-format on */

#endif
