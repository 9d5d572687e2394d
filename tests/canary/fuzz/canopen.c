/* Planted: a segment of a download is first put where four bytes have room, however many it carries. */
#include "canopen/sdo.h"

#include <string.h>

#define SEGMENT 0x00U
#define COMMAND_MASK 0xE0U

void __real_tumble_sdo_server_receive(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary,
                                      const tumble_can_frame_t *frame, uint64_t now_us);
void __wrap_tumble_sdo_server_receive(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary,
                                      const tumble_can_frame_t *frame, uint64_t now_us);

extern uint8_t canary_room[4]; /* visible, or the compiler leaves out what nobody reads */
uint8_t canary_room[4];

void __wrap_tumble_sdo_server_receive(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary,
                                      const tumble_can_frame_t *frame, uint64_t now_us)
{
    const bool segment = (frame->data[0] & COMMAND_MASK) == SEGMENT;
    if (segment && (server->transfer == (uint8_t)TUMBLE_SDO_DOWNLOAD)) {
        memcpy(canary_room, &frame->data[1], 7U - ((frame->data[0] >> 1U) & 7U));
    }
    __real_tumble_sdo_server_receive(server, dictionary, frame, now_us);
}
