/* Written by tools/objects/generate from the tables beside it: change them there. */
#include "registers.h"

#include "canopen/dictionary.h"

/* Values in a row: V(how many, register, register and bit of their validity, index, subindex, type, bytes,
 * group, key); S(..., register scaled, that of their validity, scale) are there as scaled integers, too.
 * Settings in a row: T(how many, number, index, subindex, type, bytes, group, at service level only). */
#define V(count, at, validity, bit, index, subindex, type, size, group, key) \
    {count, {at, validity, bit, index, subindex, TUMBLE_TYPE_##type, size, group, key, 0, 0, 0.0}}
#define S(count, at, validity, bit, index, subindex, type, size, group, key, scaled_at, scaled_validity, unit) \
    {count, {at, validity, bit, index, subindex, TUMBLE_TYPE_##type, size, group, key, scaled_at, \
             scaled_validity, unit}}
#define T(count, number, index, subindex, type, size, group, service) \
    {count, {number, index, subindex, TUMBLE_TYPE_##type, size, group, service}}

const gateway_value_run_t gateway_value_runs[] = {
    V(4, 101, 100, 0, 0x1018, 1, UNSIGNED32, 4, 1, 10), V(1, 111, 110, 0, 0x2000, 0, UNSIGNED8, 1, 0, 10),
    V(1, 113, 112, 0, 0x2001, 0, UNSIGNED8, 1, 0, 10), V(6, 121, 120, 0, 0x2003, 1, UNSIGNED8, 1, 0, 10),
    V(2, 127, 120, 6, 0x2003, 7, UNSIGNED32, 4, 0, 10), V(2, 131, 120, 8, 0x2003, 9, REAL64, 8, 0, 10),
    V(1, 135, 120, 10, 0x2003, 11, INTEGER8, 1, 0, 10), V(1, 136, 120, 11, 0x2003, 12, UNSIGNED8, 1, 0, 10),
    V(1, 1351, 1350, 0, 0x2003, 13, UNSIGNED8, 1, 0, 10), V(1, 1352, 1350, 1, 0x2003, 14, REAL64, 8, 0, 10),
    V(2, 115, 114, 0, 0x2004, 1, UNSIGNED8, 1, 0, 10), V(1, 117, 114, 2, 0x2004, 3, UNSIGNED16, 2, 0, 10),
    V(2, 118, 114, 3, 0x2004, 4, UNSIGNED8, 1, 0, 10), V(1, 1341, 1340, 0, 0x2004, 6, UNSIGNED16, 2, 0, 10),
    V(1, 1342, 1340, 1, 0x2004, 7, UNSIGNED8, 1, 0, 10), V(1, 1343, 1340, 2, 0x2004, 8, UNSIGNED32, 4, 0, 10),
    V(2, 1345, 1340, 3, 0x2004, 9, UNSIGNED8, 1, 0, 10), V(1, 158, 157, 0, 0x2006, 2, UNSIGNED8, 1, 0, 10),
    V(1, 159, 157, 1, 0x2006, 3, UNSIGNED16, 2, 0, 10), V(1, 148, 147, 0, 0x2007, 0, UNSIGNED32, 4, 0, 10),
    V(3, 1321, 1320, 0, 0x2008, 1, UNSIGNED32, 4, 0, 10), V(3, 141, 140, 0, 0x2010, 1, REAL64, 8, 0, 10),
    V(3, 151, 150, 0, 0x2011, 1, REAL64, 8, 0, 10), S(9, 161, 160, 0, 0x2020, 1, REAL64, 8, 1, 10, 201, 200, 1e-08),
    S(3, 181, 180, 0, 0x2021, 1, REAL64, 8, 1, 10, 221, 220, 1e-08),
    S(3, 191, 190, 0, 0x2022, 1, REAL64, 8, 0, 10, 231, 230, 1e-09), V(2, 197, 190, 3, 0x2022, 4, UNSIGNED8, 1, 0, 10),
    V(1, 199, 190, 5, 0x2022, 6, BOOLEAN, 1, 0, 10), V(9, 401, 400, 0, 0x2023, 1, REAL64, 8, 1, 10),
    V(3, 421, 420, 0, 0x2024, 1, REAL64, 8, 1, 10), V(3, 381, 380, 0, 0x2025, 1, REAL64, 8, 1, 10),
    V(1, 387, 380, 3, 0x2025, 4, UNSIGNED8, 1, 1, 10), V(4, 389, 388, 0, 0x2026, 1, REAL64, 8, 1, 10),
    V(2, 397, 388, 4, 0x2026, 5, UNSIGNED8, 1, 1, 10), V(5, 251, 250, 0, 0x2030, 1, UNSIGNED32, 4, 0, 10),
    V(9, 271, 270, 0, 0x2031, 1, UNSIGNED32, 4, 0, 10), V(8, 291, 290, 0, 0x2032, 1, UNSIGNED32, 4, 0, 10),
    V(5, 311, 310, 0, 0x2033, 1, UNSIGNED32, 4, 0, 10), V(14, 331, 330, 0, 0x2034, 1, UNSIGNED32, 4, 0, 10),
    V(6, 1301, 1300, 0, 0x2035, 1, UNSIGNED32, 4, 0, 10), V(1, 241, 240, 0, 0x2050, 1, UNSIGNED32, 4, 0, 10),
    V(1, 243, 240, 1, 0x2050, 2, UNSIGNED8, 1, 0, 10), V(1, 244, 240, 2, 0x2050, 3, UNSIGNED16, 2, 0, 10),
    V(1, 245, 240, 3, 0x2050, 4, UNSIGNED8, 1, 0, 10), V(1, 246, 240, 4, 0x2050, 5, REAL64, 8, 0, 10),
    V(2, 521, 520, 0, 0x2100, 1, UNSIGNED32, 4, 1, 10), V(2, 525, 520, 2, 0x2100, 3, UNSIGNED8, 1, 1, 10),
    V(1, 527, 520, 4, 0x2100, 5, UNSIGNED16, 2, 1, 10), V(1, 528, 520, 5, 0x2100, 6, VISIBLE_STRING, 24, 1, 10),
    V(1, 540, 520, 6, 0x2100, 7, UNSIGNED64, 8, 1, 10), V(2, 544, 520, 7, 0x2100, 8, REAL64, 8, 1, 10),
    V(5, 548, 520, 9, 0x2100, 10, UNSIGNED32, 4, 1, 10), V(2, 558, 520, 14, 0x2100, 15, INTEGER8, 1, 1, 10),
    V(2, 721, 720, 0, 0x2102, 1, UNSIGNED32, 4, 1, 10), V(2, 725, 720, 2, 0x2102, 3, UNSIGNED8, 1, 1, 10),
    V(1, 727, 720, 4, 0x2102, 5, UNSIGNED16, 2, 1, 10), V(1, 728, 720, 5, 0x2102, 6, VISIBLE_STRING, 24, 1, 10),
    V(1, 740, 720, 6, 0x2102, 7, UNSIGNED64, 8, 1, 10), V(2, 744, 720, 7, 0x2102, 8, REAL64, 8, 1, 10),
    V(5, 748, 720, 9, 0x2102, 10, UNSIGNED32, 4, 1, 10), V(2, 758, 720, 14, 0x2102, 15, INTEGER8, 1, 1, 10),
    S(9, 561, 560, 0, 0x2104, 1, REAL64, 8, 1, 10, 601, 600, 1e-08),
    S(9, 761, 760, 0, 0x2106, 1, REAL64, 8, 1, 10, 801, 800, 1e-08),
    S(3, 581, 580, 0, 0x2108, 1, REAL64, 8, 1, 10, 621, 620, 1e-08),
    S(3, 781, 780, 0, 0x210A, 1, REAL64, 8, 1, 10, 821, 820, 1e-08), V(9, 641, 640, 0, 0x210C, 1, REAL64, 8, 1, 10),
    V(9, 841, 840, 0, 0x210E, 1, REAL64, 8, 1, 10), V(3, 661, 660, 0, 0x2110, 1, REAL64, 8, 1, 10),
    V(3, 861, 860, 0, 0x2112, 1, REAL64, 8, 1, 10), V(4, 671, 670, 0, 0x2114, 1, REAL64, 8, 1, 10),
    V(2, 679, 670, 4, 0x2114, 5, UNSIGNED8, 1, 1, 10), V(4, 871, 870, 0, 0x2116, 1, REAL64, 8, 1, 10),
    V(2, 879, 870, 4, 0x2116, 5, UNSIGNED8, 1, 1, 10), V(1, 431, 430, 0, 0x2120, 1, UNSIGNED64, 8, 0, 10),
    V(3, 435, 430, 1, 0x2120, 2, UNSIGNED32, 4, 0, 10), V(2, 441, 430, 4, 0x2120, 5, UNSIGNED16, 2, 0, 10),
    V(4, 443, 430, 6, 0x2120, 7, UNSIGNED8, 1, 0, 10), V(4, 447, 430, 10, 0x2120, 11, BOOLEAN, 1, 0, 10),
    V(1, 451, 430, 14, 0x2120, 15, UNSIGNED16, 2, 0, 10), V(14, 461, 460, 0, 0x2130, 1, UNSIGNED32, 4, 0, 10),
    V(10, 491, 490, 0, 0x2131, 1, UNSIGNED32, 4, 0, 10), V(10, 691, 690, 0, 0x2140, 1, REAL64, 8, 1, 10),
    V(14, 1361, 1360, 0, 0x2141, 1, REAL64, 8, 1, 10), V(12, 901, 900, 0, 0x2163, 1, REAL64, 8, 1, 10),
    V(12, 931, 930, 0, 0x2164, 1, REAL64, 8, 1, 10), V(1, 1131, 1130, 0, 0x2122, 1, REAL64, 8, 2, 10),
    V(2, 1133, 1130, 1, 0x2122, 2, UNSIGNED32, 4, 2, 10), V(1, 1137, 1130, 3, 0x2122, 4, UNSIGNED16, 2, 2, 10),
    V(2, 1138, 1130, 4, 0x2122, 5, UNSIGNED8, 1, 2, 10), V(1, 1151, 1150, 0, 0x2123, 1, REAL32, 4, 2, 10),
    V(1, 1153, 1150, 1, 0x2123, 2, UNSIGNED8, 1, 2, 10), V(12, 1161, 1160, 0, 0x2124, 1, REAL32, 4, 2, 10),
    V(12, 1191, 1190, 0, 0x2125, 1, REAL32, 4, 2, 10), V(12, 1221, 1220, 0, 0x2126, 1, REAL32, 4, 2, 10),
    V(1, 961, 960, 0, 0x2150, 1, UNSIGNED8, 1, 3, 0), V(1, 962, 960, 1, 0x2150, 2, UNSIGNED32, 4, 3, 1),
    S(1, 964, 960, 2, 0x2150, 3, REAL64, 8, 3, 2, 981, 980, 1e-08),
    S(5, 966, 960, 3, 0x2150, 4, REAL64, 8, 3, 10, 983, 980, 1e-08),
    V(4, 1001, 1000, 0, 0x2151, 1, UNSIGNED8, 1, 3, 10), V(1, 1005, 1000, 4, 0x2151, 5, REAL64, 8, 3, 10),
    V(1, 1011, 1010, 0, 0x2152, 1, UNSIGNED16, 2, 4, 3), V(1, 1012, 1010, 1, 0x2152, 2, UNSIGNED16, 2, 4, 4),
    S(1, 1013, 1010, 2, 0x2152, 3, REAL64, 8, 4, 5, 1031, 1030, 1e-08),
    V(1, 1025, 1010, 8, 0x2152, 9, UNSIGNED16, 2, 4, 6),
    S(5, 1015, 1010, 3, 0x2152, 4, REAL64, 8, 4, 10, 1033, 1030, 1e-08),
    V(1, 1051, 1050, 0, 0x2160, 1, UNSIGNED8, 1, 5, 7), V(1, 1053, 1050, 2, 0x2160, 3, UNSIGNED32, 4, 5, 8),
    V(1, 1052, 1050, 1, 0x2160, 2, UNSIGNED8, 1, 5, 10), V(1, 1055, 1050, 3, 0x2160, 4, UNSIGNED64, 8, 5, 10),
    V(1, 1059, 1050, 4, 0x2160, 5, REAL32, 4, 5, 10), V(2, 1061, 1050, 5, 0x2160, 6, UNSIGNED8, 1, 5, 10),
    V(12, 1071, 1070, 0, 0x2161, 1, REAL32, 4, 5, 10), V(12, 1101, 1100, 0, 0x2162, 1, REAL32, 4, 5, 10),
    V(1, 1251, 1250, 0, 0x2170, 1, UNSIGNED32, 4, 6, 9), V(2, 1253, 1250, 1, 0x2170, 2, UNSIGNED32, 4, 6, 10),
};

const gateway_object_t gateway_tells[GATEWAY_MARKS + GATEWAY_KEYS] = {
    {0x2007U, 0U, TUMBLE_TYPE_UNSIGNED32, 4U},
    {0x2020U, 1U, TUMBLE_TYPE_REAL64, 8U},
    {0x2021U, 3U, TUMBLE_TYPE_REAL64, 8U},
    {0x2120U, 2U, TUMBLE_TYPE_UNSIGNED32, 4U},
    {0x2120U, 7U, TUMBLE_TYPE_UNSIGNED8, 1U},
    {0x2130U, 1U, TUMBLE_TYPE_UNSIGNED32, 4U},
    {0x2130U, 6U, TUMBLE_TYPE_UNSIGNED32, 4U},
    {0x2150U, 1U, TUMBLE_TYPE_UNSIGNED8, 1U},
    {0x2150U, 2U, TUMBLE_TYPE_UNSIGNED32, 4U},
    {0x2150U, 3U, TUMBLE_TYPE_REAL64, 8U},
    {0x2152U, 1U, TUMBLE_TYPE_UNSIGNED16, 2U},
    {0x2152U, 2U, TUMBLE_TYPE_UNSIGNED16, 2U},
    {0x2152U, 3U, TUMBLE_TYPE_REAL64, 8U},
    {0x2152U, 9U, TUMBLE_TYPE_UNSIGNED16, 2U},
    {0x2160U, 1U, TUMBLE_TYPE_UNSIGNED8, 1U},
    {0x2160U, 3U, TUMBLE_TYPE_UNSIGNED32, 4U},
    {0x2170U, 1U, TUMBLE_TYPE_UNSIGNED32, 4U},
};

const uint8_t gateway_selectors[GATEWAY_GROUPS] = {
    10U, 10U, 10U, 0U, 3U, 7U, 9U,
};

const gateway_target_run_t gateway_target_runs[GATEWAY_TARGET_RUNS] = {
    T(1, 1, 0x2050, 1, UNSIGNED32, 4, 0, false), T(1, 2, 0x2050, 2, UNSIGNED8, 1, 0, false),
    T(1, 3, 0x2050, 3, UNSIGNED16, 2, 0, false), T(1, 4, 0x2050, 4, UNSIGNED8, 1, 0, false),
    T(1, 5, 0x2050, 5, REAL64, 8, 0, true), T(1, 11, 0x2121, 1, UNSIGNED64, 8, 0, false),
    T(1, 12, 0x2121, 2, UNSIGNED16, 2, 0, false), T(1, 21, 0x2122, 1, REAL64, 8, 2, false),
    T(2, 22, 0x2122, 2, UNSIGNED32, 4, 2, false), T(1, 24, 0x2122, 4, UNSIGNED16, 2, 2, false),
    T(1, 25, 0x2122, 5, UNSIGNED8, 1, 2, false), T(1, 26, 0x2122, 6, UNSIGNED8, 1, 2, true),
    T(1, 31, 0x2123, 1, REAL32, 4, 2, true), T(1, 32, 0x2123, 2, UNSIGNED8, 1, 2, true),
    T(12, 41, 0x2124, 1, REAL32, 4, 2, true), T(12, 61, 0x2125, 1, REAL32, 4, 2, true),
    T(12, 81, 0x2126, 1, REAL32, 4, 2, true), T(1, 101, 0x2150, 1, UNSIGNED8, 1, 3, false),
    T(1, 111, 0x2152, 1, UNSIGNED16, 2, 4, false), T(1, 121, 0x2160, 1, UNSIGNED8, 1, 5, false),
    T(1, 131, 0x1010, 1, UNSIGNED32, 4, 0, true), T(1, 141, 0x1011, 1, UNSIGNED32, 4, 0, true),
    T(1, 151, 0x2006, 1, UNSIGNED32, 4, 0, false),
};

const uint16_t gateway_command_objects[GATEWAY_COMMAND_OBJECTS] = {
    0x2002U, /* Command */
};
