/* sdo_frame.h - the command byte of an SDO frame (CiA 301, figures 22 to 29); private to canopen. */
#ifndef TUMBLE_CANOPEN_SDO_FRAME_H
#define TUMBLE_CANOPEN_SDO_FRAME_H

#include <stdint.h>

#define TUMBLE_SDO_COMMAND_MASK 0xE0U

/* Requests of the client. */
#define TUMBLE_SDO_DOWNLOAD_SEGMENT_REQUEST 0x00U
#define TUMBLE_SDO_DOWNLOAD_REQUEST 0x20U
#define TUMBLE_SDO_UPLOAD_REQUEST 0x40U
#define TUMBLE_SDO_UPLOAD_SEGMENT_REQUEST 0x60U

/* Answers of the server. */
#define TUMBLE_SDO_UPLOAD_SEGMENT_ANSWER 0x00U
#define TUMBLE_SDO_DOWNLOAD_SEGMENT_ANSWER 0x20U
#define TUMBLE_SDO_UPLOAD_ANSWER 0x40U
#define TUMBLE_SDO_DOWNLOAD_ANSWER 0x60U

#define TUMBLE_SDO_ABORT 0x80U /* of both */

/* Bits of the first request or answer. */
#define TUMBLE_SDO_S 0x01U /* the size is indicated */
#define TUMBLE_SDO_E 0x02U /* expedited: the value is in the frame; bits 2 and 3 count its unused bytes */

/* Bits of a segment; bits 1 to 3 count its unused bytes. */
#define TUMBLE_SDO_C 0x01U /* the last one */
#define TUMBLE_SDO_TOGGLE 0x10U

#define TUMBLE_SDO_EXPEDITED 4U /* bytes in the first frame */
#define TUMBLE_SDO_SEGMENT 7U   /* bytes in a segment */

/* Command byte of a frame that carries `size` (1 to 4) bytes itself. */
static inline uint8_t tumble_sdo_expedited(uint8_t command, uint8_t size)
{
    uint8_t unused = (uint8_t)(TUMBLE_SDO_EXPEDITED - size);
    return (uint8_t)(command | TUMBLE_SDO_E | TUMBLE_SDO_S | (uint8_t)(unused << 2));
}

#endif
