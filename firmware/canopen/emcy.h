/* emcy.h - emergency messages (CiA 301, 7.2.7): producer with error register (1001h) and history (1003h).
 *
 * An error is raised once and later cleared by the bit of the error register that it set; when the last one is cleared
 * the message "no error" (0000h) goes out. Messages wait for the port in a short queue; one that finds it full still
 * enters register and history, and is counted.
 */
#ifndef TUMBLE_CANOPEN_EMCY_H
#define TUMBLE_CANOPEN_EMCY_H

#include "canopen/link.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_EMCY_ID 0x080U /* + node */
#define TUMBLE_EMCY_HISTORY 4
#define TUMBLE_EMCY_QUEUE 4
#define TUMBLE_EMCY_INFO_BYTES 5

/* Bits of the error register. */
#define TUMBLE_ERROR_GENERIC 0x01U /* set with any other */
#define TUMBLE_ERROR_CURRENT 0x02U
#define TUMBLE_ERROR_VOLTAGE 0x04U
#define TUMBLE_ERROR_TEMPERATURE 0x08U
#define TUMBLE_ERROR_COMMUNICATION 0x10U
#define TUMBLE_ERROR_PROFILE 0x20U
#define TUMBLE_ERROR_MANUFACTURER 0x80U

/* Error codes that canopen raises by itself. */
#define TUMBLE_EMCY_NO_ERROR 0x0000U
#define TUMBLE_EMCY_HEARTBEAT 0x8130U
#define TUMBLE_EMCY_PDO_LENGTH 0x8210U

/* The navigation computer's own. First info byte: */
#define TUMBLE_EMCY_SERVICE_LEVEL 0xFF30U /* the level (2006h:2), 1: open. Cleared when it is normal again */

/* One emergency message, as sent and as received. */
typedef struct {
    uint16_t code;
    uint8_t error_register;
    uint8_t info[TUMBLE_EMCY_INFO_BYTES]; /* the maker's own */
} tumble_emergency_t;

typedef struct {
    uint8_t node;
    uint8_t error_register;
    uint8_t recorded; /* entries of the history */
    uint8_t queued;
    uint16_t overflow;                     /* messages that found the queue full */
    uint32_t history[TUMBLE_EMCY_HISTORY]; /* newest first: code, and the first two info bytes above it */
    tumble_emergency_t queue[TUMBLE_EMCY_QUEUE];
} tumble_emcy_t;

void tumble_emcy_init(tumble_emcy_t *emcy, uint8_t node);

/* Raise an error: `bits` are set in the register (GENERIC by itself), the history gets an entry, a message is queued.
 * `info` may be null: zeros. */
void tumble_emcy_raise(tumble_emcy_t *emcy, uint16_t code, uint8_t bits, const uint8_t info[TUMBLE_EMCY_INFO_BYTES]);

/* The same with a number for `info`, low byte first. */
void tumble_emcy_tell(tumble_emcy_t *emcy, uint16_t code, uint8_t bits, uint32_t detail);

/* Clear bits of the register; when no other than GENERIC is left, the register becomes 0 and "no error" is queued. No
 * effect when the register is 0 already. */
void tumble_emcy_clear(tumble_emcy_t *emcy, uint8_t bits);

/* Send what is queued, oldest first. */
void tumble_emcy_step(tumble_emcy_t *emcy, tumble_link_t *link);

/* Take another node's message apart. False when it is not eight bytes long. */
bool tumble_emcy_parse(const tumble_can_frame_t *frame, uint8_t *node, tumble_emergency_t *emergency);

#endif
