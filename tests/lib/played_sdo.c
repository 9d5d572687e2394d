#include "played_sdo.h"

#include "canopen/sdo_frame.h"
#include "core/bytes.h"

#include <string.h>

#define NO_DATA 0x08000024U
#define SEGMENT 7U

static void send(const played_sdo_t *self, const uint8_t *bytes)
{
    const unsigned id = (self->is_second ? TUMBLE_SDO_SECOND_RESPONSE_ID : TUMBLE_SDO_RESPONSE_ID) + self->node;
    tumble_can_frame_t frame = {.id = (uint16_t)id, .length = 8};
    memcpy(frame.data, bytes, sizeof frame.data);
    self->send(&frame);
}

/* To the request that names the object. */
static void answer(const played_sdo_t *self, uint8_t command, const uint8_t *request, uint32_t value)
{
    uint8_t bytes[8] = {command, request[1], request[2], request[3]};
    tumble_put_u32(&bytes[4], value);
    send(self, bytes);
}

played_object_t *played_sdo_find(played_sdo_t *self, uint16_t index, uint8_t subindex)
{
    unsigned i = 0;
    while (i < self->count && (self->objects[i].index != index || self->objects[i].subindex != subindex)) {
        i++;
    }
    return (i < self->count) ? &self->objects[i] : NULL;
}

void played_sdo_give(played_sdo_t *self, uint16_t index, uint8_t subindex, const uint8_t *bytes, uint8_t size)
{
    played_object_t *object = played_sdo_find(self, index, subindex);
    if (object == NULL && self->count < PLAYED_OBJECTS) {
        object = &self->objects[self->count++];
    }
    if (object != NULL) {
        *object = (played_object_t){.index = index, .subindex = subindex, .size = size};
        memcpy(object->bytes, bytes, size);
    }
}

static void upload(played_sdo_t *self, const uint8_t *request)
{
    const uint32_t refusal = (self->may_read != NULL) ? self->may_read(tumble_get_u16(&request[1]), request[3]) : 0U;
    const played_object_t *const object = played_sdo_find(self, tumble_get_u16(&request[1]), request[3]);
    if (refusal != 0U || object == NULL || object->size == 0U) {
        answer(self, TUMBLE_SDO_ABORT, request, (refusal != 0U) ? refusal : NO_DATA);
    } else if (object->size <= 4U) {
        answer(self, tumble_sdo_expedited(TUMBLE_SDO_UPLOAD_ANSWER, object->size), request,
               tumble_get_u32(object->bytes));
    } else {
        self->upload = *object;
        self->sent = 0;
        answer(self, TUMBLE_SDO_UPLOAD_ANSWER | TUMBLE_SDO_S, request, object->size);
    }
}

static void upload_segment(played_sdo_t *self, const uint8_t *request)
{
    const unsigned left = self->upload.size - self->sent;
    const unsigned now = (left > SEGMENT) ? SEGMENT : left;
    uint8_t bytes[8] = {
        (uint8_t)((request[0] & TUMBLE_SDO_TOGGLE) | (SEGMENT - now) << 1 | ((now == left) ? TUMBLE_SDO_C : 0U))};
    memcpy(&bytes[1], &self->upload.bytes[self->sent], now);
    self->sent += now;
    send(self, bytes);
}

static void take(played_sdo_t *self, const uint8_t *request, unsigned size, const uint8_t *acknowledgement,
                 bool is_last)
{
    memcpy(&self->written.bytes[self->written.size], request, size);
    self->written.size = (uint8_t)(self->written.size + size);
    memcpy(self->acknowledgement, acknowledgement, sizeof self->acknowledgement);
    if (!is_last || self->on_write()) {
        played_sdo_acknowledge(self);
    }
}

static void download(played_sdo_t *self, const uint8_t *request)
{
    const uint8_t taken[8] = {TUMBLE_SDO_DOWNLOAD_ANSWER, request[1], request[2], request[3]};
    const bool is_expedited = (request[0] & TUMBLE_SDO_E) != 0U;
    self->written = (played_object_t){.index = tumble_get_u16(&request[1]), .subindex = request[3]};
    const uint32_t refusal = self->may_write(self->written.index, self->written.subindex);
    if (refusal != 0U) {
        answer(self, TUMBLE_SDO_ABORT, request, refusal);
    } else {
        take(self, &request[4], is_expedited ? 4U - ((request[0] >> 2) & 3U) : 0U, taken, is_expedited);
    }
}

static void download_segment(played_sdo_t *self, const uint8_t *request)
{
    const uint8_t taken[8] = {(uint8_t)(TUMBLE_SDO_DOWNLOAD_SEGMENT_ANSWER | (request[0] & TUMBLE_SDO_TOGGLE))};
    take(self, &request[1], SEGMENT - ((request[0] >> 1) & SEGMENT), taken, (request[0] & TUMBLE_SDO_C) != 0U);
}

void played_sdo_acknowledge(const played_sdo_t *self)
{
    send(self, self->acknowledgement);
}

bool played_sdo_receive(played_sdo_t *self, const tumble_can_frame_t *frame)
{
    const bool is_second = frame->id == TUMBLE_SDO_SECOND_REQUEST_ID + self->node;
    if (!is_second && frame->id != TUMBLE_SDO_REQUEST_ID + self->node) {
        return false;
    }
    self->is_second = is_second;
    if (self->silent || (is_second && self->has_one_server)) {
        return true;
    }
    switch (frame->data[0] & TUMBLE_SDO_COMMAND_MASK) {
    case TUMBLE_SDO_UPLOAD_REQUEST:
        upload(self, frame->data);
        break;
    case TUMBLE_SDO_UPLOAD_SEGMENT_REQUEST:
        upload_segment(self, frame->data);
        break;
    case TUMBLE_SDO_DOWNLOAD_REQUEST:
        download(self, frame->data);
        break;
    case TUMBLE_SDO_DOWNLOAD_SEGMENT_REQUEST:
        download_segment(self, frame->data);
        break;
    default:
        break;
    }
    return true;
}
