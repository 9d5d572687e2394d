/* cia402.h - the numbers of CiA 402 (drives) that both ends of the bus use: objects, controlword, statusword, modes.
 *
 * Source: CiA 402-2 (IEC 61800-7-201), profile position and homing modes.
 */
#ifndef TUMBLE_CANOPEN_CIA402_H
#define TUMBLE_CANOPEN_CIA402_H

#include <stdint.h>

/* Objects, subindex 0 unless the name says otherwise. */
#define TUMBLE_402_ERROR_CODE 0x603FU
#define TUMBLE_402_CONTROLWORD 0x6040U
#define TUMBLE_402_STATUSWORD 0x6041U
#define TUMBLE_402_MODE 0x6060U
#define TUMBLE_402_MODE_DISPLAY 0x6061U
#define TUMBLE_402_POSITION_ACTUAL 0x6064U
#define TUMBLE_402_VELOCITY_ACTUAL 0x606CU
#define TUMBLE_402_TARGET_POSITION 0x607AU
#define TUMBLE_402_HOME_OFFSET 0x607CU
#define TUMBLE_402_SOFTWARE_LIMIT 0x607DU /* subindex 1: lowest position, 2: highest */
#define TUMBLE_402_PROFILE_VELOCITY 0x6081U
#define TUMBLE_402_PROFILE_ACCELERATION 0x6083U
#define TUMBLE_402_PROFILE_DECELERATION 0x6084U
#define TUMBLE_402_QUICK_STOP_DECELERATION 0x6085U
#define TUMBLE_402_HOMING_METHOD 0x6098U
#define TUMBLE_402_HOMING_SPEED 0x6099U
#define TUMBLE_402_HOMING_ACCELERATION 0x609AU

/* 6060h, 6061h. */
#define TUMBLE_402_MODE_NONE 0
#define TUMBLE_402_MODE_PROFILE_POSITION 1
#define TUMBLE_402_MODE_HOMING 6

/* 6040h: commands of the power state machine (mask 008Fh), then the bits of the mode. */
#define TUMBLE_402_CONTROL_MASK 0x008FU
#define TUMBLE_402_CONTROL_DISABLE_VOLTAGE 0x0000U
#define TUMBLE_402_CONTROL_QUICK_STOP 0x0002U
#define TUMBLE_402_CONTROL_SHUTDOWN 0x0006U
#define TUMBLE_402_CONTROL_SWITCH_ON 0x0007U
#define TUMBLE_402_CONTROL_ENABLE 0x000FU
#define TUMBLE_402_CONTROL_FAULT_RESET 0x0080U    /* acts on its rising edge */
#define TUMBLE_402_CONTROL_NEW_SET_POINT 0x0010U  /* profile position; rising edge */
#define TUMBLE_402_CONTROL_CHANGE_AT_ONCE 0x0020U /* profile position */
#define TUMBLE_402_CONTROL_RELATIVE 0x0040U       /* profile position */
#define TUMBLE_402_CONTROL_START_HOMING 0x0010U   /* homing */
#define TUMBLE_402_CONTROL_HALT 0x0100U

/* 6041h: the state, as `statusword & STATE_MASK`. Bit 5 does not count in the first, second and last ones. */
#define TUMBLE_402_STATE_MASK 0x006FU
#define TUMBLE_402_STATE_MASK_SHORT 0x004FU
#define TUMBLE_402_STATE_NOT_READY 0x0000U          /* mask SHORT */
#define TUMBLE_402_STATE_SWITCH_ON_DISABLED 0x0040U /* mask SHORT */
#define TUMBLE_402_STATE_READY_TO_SWITCH_ON 0x0021U
#define TUMBLE_402_STATE_SWITCHED_ON 0x0023U
#define TUMBLE_402_STATE_OPERATION_ENABLED 0x0027U
#define TUMBLE_402_STATE_QUICK_STOP_ACTIVE 0x0007U
#define TUMBLE_402_STATE_FAULT_REACTION 0x000FU /* mask SHORT */
#define TUMBLE_402_STATE_FAULT 0x0008U          /* mask SHORT */
#define TUMBLE_402_STATUS_VOLTAGE 0x0010U
#define TUMBLE_402_STATUS_WARNING 0x0080U
#define TUMBLE_402_STATUS_REMOTE 0x0200U
#define TUMBLE_402_STATUS_TARGET_REACHED 0x0400U
#define TUMBLE_402_STATUS_LIMIT_ACTIVE 0x0800U
#define TUMBLE_402_STATUS_SET_POINT_ACKNOWLEDGE 0x1000U /* profile position */
#define TUMBLE_402_STATUS_FOLLOWING_ERROR 0x2000U       /* profile position */
#define TUMBLE_402_STATUS_HOMING_ATTAINED 0x1000U       /* homing */
#define TUMBLE_402_STATUS_HOMING_ERROR 0x2000U          /* homing */

/* 603Fh and EMCY error codes. */
#define TUMBLE_402_ERROR_FOLLOWING 0x8611U
#define TUMBLE_402_ERROR_HEARTBEAT 0x8130U

/* A master's picture of a drive's objects, filled by its receive PDO and sent by its transmit PDO: what the navigation
 * computer's dictionary holds for its drive (TUMBLE_HOME_OTHER; 2040h). */
typedef struct {
    int32_t target_position;
    int32_t actual_position;
    int32_t actual_velocity;
    uint16_t controlword;
    uint16_t statusword;
    uint16_t error_code;
    int8_t mode;
    int8_t mode_display;
} tumble_drive_mirror_t;

#endif
