#include "canopen/emcy.h"

#include "core/bytes.h"

#include <stddef.h>
#include <string.h>

void tumble_emcy_init(tumble_emcy_t *emcy, uint8_t node)
{
    (void)memset(emcy, 0, sizeof *emcy);
    emcy->node = node;
}

static void enqueue(tumble_emcy_t *emcy, const tumble_emergency_t *emergency)
{
    if (emcy->queued < TUMBLE_EMCY_QUEUE) {
        emcy->queue[emcy->queued] = *emergency;
        ++emcy->queued;
    } else {
        tumble_count_u16(&emcy->overflow);
    }
}

static void record(tumble_emcy_t *emcy, const tumble_emergency_t *emergency)
{
    (void)memmove(&emcy->history[1], &emcy->history[0], (TUMBLE_EMCY_HISTORY - 1U) * sizeof emcy->history[0]);
    emcy->history[0] = emergency->code | ((uint32_t)emergency->info[0] << 16) | ((uint32_t)emergency->info[1] << 24);
    if (emcy->recorded < TUMBLE_EMCY_HISTORY) {
        ++emcy->recorded;
    }
}

void tumble_emcy_raise(tumble_emcy_t *emcy, uint16_t code, uint8_t bits, const uint8_t info[TUMBLE_EMCY_INFO_BYTES])
{
    tumble_emergency_t emergency = {.code = code};
    if (info != NULL) {
        (void)memcpy(emergency.info, info, TUMBLE_EMCY_INFO_BYTES);
    }
    emcy->error_register |= (uint8_t)(bits | TUMBLE_ERROR_GENERIC);
    emergency.error_register = emcy->error_register;
    record(emcy, &emergency);
    enqueue(emcy, &emergency);
}

void tumble_emcy_tell(tumble_emcy_t *emcy, uint16_t code, uint8_t bits, uint32_t detail)
{
    uint8_t info[TUMBLE_EMCY_INFO_BYTES] = {0};
    tumble_put_u32(info, detail);
    tumble_emcy_raise(emcy, code, bits, info);
}

void tumble_emcy_clear(tumble_emcy_t *emcy, uint8_t bits)
{
    if (emcy->error_register != 0U) {
        emcy->error_register &= (uint8_t)~bits;
        if ((emcy->error_register & (uint8_t)~TUMBLE_ERROR_GENERIC) == 0U) {
            tumble_emergency_t gone = {.code = TUMBLE_EMCY_NO_ERROR};
            emcy->error_register = 0;
            enqueue(emcy, &gone);
        }
    }
}

void tumble_emcy_step(tumble_emcy_t *emcy, tumble_link_t *link)
{
    tumble_status_t status = TUMBLE_OK;
    while ((emcy->queued > 0U) && (status == TUMBLE_OK)) {
        tumble_can_frame_t frame = {.id = (uint16_t)(TUMBLE_EMCY_ID + emcy->node), .length = 8};
        tumble_put_u16(&frame.data[0], emcy->queue[0].code);
        frame.data[2] = emcy->queue[0].error_register;
        (void)memcpy(&frame.data[3], emcy->queue[0].info, TUMBLE_EMCY_INFO_BYTES);
        status = tumble_link_send(link, &frame);
        if (status == TUMBLE_OK) {
            --emcy->queued;
            (void)memmove(&emcy->queue[0], &emcy->queue[1], emcy->queued * sizeof emcy->queue[0]);
        }
    }
}

bool tumble_emcy_parse(const tumble_can_frame_t *frame, uint8_t *node, tumble_emergency_t *emergency)
{
    if (frame->length != 8U) {
        return false;
    }
    *node = (uint8_t)(frame->id - TUMBLE_EMCY_ID);
    emergency->code = tumble_get_u16(&frame->data[0]);
    emergency->error_register = frame->data[2];
    (void)memcpy(emergency->info, &frame->data[3], TUMBLE_EMCY_INFO_BYTES);
    return true;
}
