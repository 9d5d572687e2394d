#include "canopen/sdo.h"
#include "canopen/sdo_frame.h"
#include "core/bytes.h"
#include "core/one_copy.h"

#include <string.h>

#define MAX_NODE 127U

/* What an answer is waited for. */
enum { PHASE_FIRST = 0, PHASE_SEGMENT };

void tumble_sdo_client_init(tumble_sdo_client_t *client)
{
    (void)memset(client, 0, sizeof *client);
    client->deadline_us = TUMBLE_NEVER;
    client->result = TUMBLE_OK;
    client->sink = client->value;
    client->below = TUMBLE_SDO_TO_FIRST;
}

static void request(tumble_sdo_client_t *client, uint8_t command)
{
    (void)memset(client->request, 0, sizeof client->request);
    client->request[0] = command;
    client->request_due = true;
    client->deadline_us = TUMBLE_NEVER;
}

static void request_with_object(tumble_sdo_client_t *client, uint8_t command)
{
    request(client, command);
    tumble_put_u16(&client->request[1], client->index);
    client->request[3] = client->subindex;
}

TUMBLE_ONE_COPY static void end_transfer(tumble_sdo_client_t *client, tumble_status_t result, uint32_t abort)
{
    client->result = result;
    client->abort = abort;
    client->deadline_us = TUMBLE_NEVER;
    client->transfer = (uint8_t)TUMBLE_SDO_IDLE;
}

/* End it and tell the server why. */
static void abort_transfer(tumble_sdo_client_t *client, tumble_status_t result, tumble_abort_t reason)
{
    end_transfer(client, result, (uint32_t)reason);
    request_with_object(client, TUMBLE_SDO_ABORT);
    tumble_put_u32(&client->request[4], (uint32_t)reason);
}

TUMBLE_ONE_COPY static tumble_status_t begin(tumble_sdo_client_t *client, uint8_t node, uint16_t index,
                                             uint8_t subindex)
{
    if (client->result == TUMBLE_E_SDO_BUSY) {
        return TUMBLE_E_SDO_BUSY;
    }
    if ((node == 0U) || (node > MAX_NODE)) {
        return TUMBLE_E_ARGUMENT;
    }
    client->node = node;
    client->index = index;
    client->subindex = subindex;
    client->phase = PHASE_FIRST;
    client->sink = client->value;
    client->done = 0;
    client->size = 0;
    client->toggle = 0;
    client->abort = 0;
    client->result = TUMBLE_E_SDO_BUSY;
    return TUMBLE_OK;
}

tumble_status_t tumble_sdo_client_read_into(tumble_sdo_client_t *client, uint8_t node, uint16_t index, uint8_t subindex,
                                            uint8_t *data, uint8_t capacity)
{
    if ((data == NULL) || (capacity == 0U)) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status = begin(client, node, index, subindex);
    if (status == TUMBLE_OK) {
        client->sink = data;
        client->capacity = capacity;
        client->transfer = (uint8_t)TUMBLE_SDO_UPLOAD;
        request_with_object(client, TUMBLE_SDO_UPLOAD_REQUEST);
    }
    return status;
}

tumble_status_t tumble_sdo_client_read(tumble_sdo_client_t *client, uint8_t node, uint16_t index, uint8_t subindex)
{
    return tumble_sdo_client_read_into(client, node, index, subindex, client->value, (uint8_t)sizeof client->value);
}

static void begin_download(tumble_sdo_client_t *client, const uint8_t *data, uint8_t size)
{
    client->source = data;
    client->size = size;
    client->transfer = (uint8_t)TUMBLE_SDO_DOWNLOAD;
    if (size <= TUMBLE_SDO_EXPEDITED) {
        request_with_object(client, tumble_sdo_expedited(TUMBLE_SDO_DOWNLOAD_REQUEST, size));
        (void)memcpy(&client->request[4], data, size);
        client->done = size;
    } else {
        request_with_object(client, TUMBLE_SDO_DOWNLOAD_REQUEST | TUMBLE_SDO_S);
        client->request[4] = size;
    }
}

tumble_status_t tumble_sdo_client_write(tumble_sdo_client_t *client, uint8_t node, uint16_t index, uint8_t subindex,
                                        uint32_t value, uint8_t size)
{
    if ((size != 1U) && (size != 2U) && (size != 4U)) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status = begin(client, node, index, subindex);
    if (status == TUMBLE_OK) {
        tumble_put_u32(client->value, value);
        begin_download(client, client->value, size);
    }
    return status;
}

tumble_status_t tumble_sdo_client_write_from(tumble_sdo_client_t *client, uint8_t node, uint16_t index,
                                             uint8_t subindex, const uint8_t *data, uint8_t size)
{
    if ((data == NULL) || (size == 0U)) {
        return TUMBLE_E_ARGUMENT;
    }
    const tumble_status_t status = begin(client, node, index, subindex);
    if (status == TUMBLE_OK) {
        begin_download(client, data, size);
    }
    return status;
}

void tumble_sdo_client_cancel(tumble_sdo_client_t *client)
{
    if (client->result == TUMBLE_E_SDO_BUSY) {
        abort_transfer(client, TUMBLE_E_SDO_ABORTED, TUMBLE_ABORT_GENERAL);
    }
}

TUMBLE_ONE_COPY void tumble_sdo_client_drop(tumble_sdo_client_t *client)
{
    if (client->result == TUMBLE_E_SDO_BUSY) {
        end_transfer(client, TUMBLE_E_SDO_ABORTED, (uint32_t)TUMBLE_ABORT_DEVICE_STATE);
    }
    client->request_due = false;
}

static void refuse(tumble_sdo_client_t *client, tumble_abort_t reason)
{
    abort_transfer(client, TUMBLE_E_SDO_ABORTED, reason);
}

/* Append received bytes to the value; false when the transfer had to be aborted. */
static bool append(tumble_sdo_client_t *client, const uint8_t *bytes, uint8_t length)
{
    if (length > (client->capacity - client->done)) {
        refuse(client, TUMBLE_ABORT_MEMORY);
        return false;
    }
    (void)memcpy(&client->sink[client->done], bytes, length);
    client->done = (uint8_t)(client->done + length);
    return true;
}

static void upload_begun(tumble_sdo_client_t *client, const tumble_can_frame_t *frame)
{
    uint8_t command = frame->data[0];
    uint32_t announced = ((command & TUMBLE_SDO_S) != 0U) ? tumble_get_u32(&frame->data[4]) : 0U;
    if ((command & TUMBLE_SDO_E) != 0U) {
        uint8_t unused = ((command & TUMBLE_SDO_S) != 0U) ? ((command >> 2) & 3U) : 0U;
        if (append(client, &frame->data[4], (uint8_t)(TUMBLE_SDO_EXPEDITED - unused))) {
            end_transfer(client, TUMBLE_OK, 0);
        }
    } else if (announced > client->capacity) {
        refuse(client, TUMBLE_ABORT_MEMORY);
    } else {
        client->size = (uint8_t)announced;
        client->phase = PHASE_SEGMENT;
        request(client, TUMBLE_SDO_UPLOAD_SEGMENT_REQUEST);
    }
}

static void upload_segment(tumble_sdo_client_t *client, const tumble_can_frame_t *frame)
{
    const uint8_t command = frame->data[0];
    const uint8_t length = (uint8_t)(TUMBLE_SDO_SEGMENT - ((command >> 1) & 7U));
    const bool last = (command & TUMBLE_SDO_C) != 0U;
    if (!append(client, &frame->data[1], length)) {
        return;
    }
    const bool too_much = (client->size != 0U) && (client->done > client->size);
    const bool too_little = last && (client->size != 0U) && (client->done < client->size);
    const bool endless = !last && (length == 0U);
    if (too_much || too_little || endless) {
        refuse(client, TUMBLE_ABORT_LENGTH);
    } else if (last) {
        end_transfer(client, TUMBLE_OK, 0);
    } else {
        client->toggle ^= TUMBLE_SDO_TOGGLE;
        request(client, (uint8_t)(TUMBLE_SDO_UPLOAD_SEGMENT_REQUEST | client->toggle));
    }
}

static void send_download_segment(tumble_sdo_client_t *client)
{
    uint8_t rest = (uint8_t)(client->size - client->done);
    uint8_t length = (rest < TUMBLE_SDO_SEGMENT) ? rest : TUMBLE_SDO_SEGMENT;
    uint8_t last = (length == rest) ? TUMBLE_SDO_C : 0U;
    request(client, (uint8_t)(TUMBLE_SDO_DOWNLOAD_SEGMENT_REQUEST | client->toggle |
                              ((TUMBLE_SDO_SEGMENT - length) << 1) | last));
    (void)memcpy(&client->request[1], &client->source[client->done], length);
    client->done = (uint8_t)(client->done + length);
}

/* The server has taken what was sent: go on with the next segment, if there is one. */
static void download_acknowledged(tumble_sdo_client_t *client)
{
    if (client->done == client->size) {
        end_transfer(client, TUMBLE_OK, 0);
        return;
    }
    client->toggle ^= (client->phase == PHASE_SEGMENT) ? TUMBLE_SDO_TOGGLE : 0U;
    client->phase = PHASE_SEGMENT;
    send_download_segment(client);
}

static bool names_object(const tumble_sdo_client_t *client, const tumble_can_frame_t *frame)
{
    return (tumble_get_u16(&frame->data[1]) == client->index) && (frame->data[3] == client->subindex);
}

/* The answer to the first request. Anything but the one expected is left over from an earlier transfer, and ignored: if
 * the right one does not come, time runs out. */
static void first_answer(tumble_sdo_client_t *client, const tumble_can_frame_t *frame)
{
    bool upload = client->transfer == (uint8_t)TUMBLE_SDO_UPLOAD;
    uint8_t expected = upload ? TUMBLE_SDO_UPLOAD_ANSWER : TUMBLE_SDO_DOWNLOAD_ANSWER;
    if (!names_object(client, frame) || ((frame->data[0] & TUMBLE_SDO_COMMAND_MASK) != expected)) {
        tumble_count_u16(&client->ignored);
    } else if (upload) {
        upload_begun(client, frame);
    } else {
        download_acknowledged(client);
    }
}

static void segment_answer(tumble_sdo_client_t *client, const tumble_can_frame_t *frame)
{
    bool upload = client->transfer == (uint8_t)TUMBLE_SDO_UPLOAD;
    uint8_t expected = upload ? TUMBLE_SDO_UPLOAD_SEGMENT_ANSWER : TUMBLE_SDO_DOWNLOAD_SEGMENT_ANSWER;
    if ((frame->data[0] & TUMBLE_SDO_COMMAND_MASK) != expected) {
        refuse(client, TUMBLE_ABORT_COMMAND);
    } else if ((frame->data[0] & TUMBLE_SDO_TOGGLE) != client->toggle) {
        refuse(client, TUMBLE_ABORT_TOGGLE);
    } else if (upload) {
        upload_segment(client, frame);
    } else {
        download_acknowledged(client);
    }
}

/* An abort of the first request must name its object, or it belongs to an earlier one. */
static void aborted(tumble_sdo_client_t *client, const tumble_can_frame_t *frame)
{
    if ((client->phase == PHASE_FIRST) && !names_object(client, frame)) {
        tumble_count_u16(&client->ignored);
    } else {
        end_transfer(client, TUMBLE_E_SDO_ABORTED, tumble_get_u32(&frame->data[4]));
    }
}

void tumble_sdo_client_receive(tumble_sdo_client_t *client, const tumble_can_frame_t *frame)
{
    if (frame->id != (TUMBLE_SDO_RESPONSE_ID + client->node - client->below)) {
        return;
    }
    if ((frame->length != TUMBLE_CAN_MAX_BYTES) || (client->result != TUMBLE_E_SDO_BUSY) || client->request_due) {
        tumble_count_u16(&client->ignored);
    } else if ((frame->data[0] & TUMBLE_SDO_COMMAND_MASK) == TUMBLE_SDO_ABORT) {
        aborted(client, frame);
    } else if (client->phase == PHASE_FIRST) {
        first_answer(client, frame);
    } else {
        segment_answer(client, frame);
    }
}

/* Time runs from the first offer to the port, and anew from the moment that the port takes the frame. */
static void send_request(tumble_sdo_client_t *client, tumble_link_t *link, uint64_t now_us)
{
    bool busy = client->result == TUMBLE_E_SDO_BUSY;
    client->request_due = tumble_link_send_bytes(link, TUMBLE_SDO_REQUEST_ID + (uint32_t)client->node - client->below,
                                                 client->request, sizeof client->request) != TUMBLE_OK;
    if (busy && (!client->request_due || (client->deadline_us == TUMBLE_NEVER))) {
        client->deadline_us = now_us + TUMBLE_SDO_CLIENT_TIMEOUT_US;
    }
}

void tumble_sdo_client_step(tumble_sdo_client_t *client, tumble_link_t *link, uint64_t now_us)
{
    if (now_us >= client->deadline_us) {
        abort_transfer(client, TUMBLE_E_SDO_TIMEOUT, TUMBLE_ABORT_TIMEOUT);
    }
    if (client->request_due) {
        send_request(client, link, now_us);
    }
}

tumble_status_t tumble_sdo_client_result(const tumble_sdo_client_t *client)
{
    return client->result;
}

const uint8_t *tumble_sdo_client_data(const tumble_sdo_client_t *client, uint8_t *size)
{
    *size = client->done;
    return client->sink;
}

uint32_t tumble_sdo_client_u32(const tumble_sdo_client_t *client)
{
    uint8_t size;
    const uint8_t *data = tumble_sdo_client_data(client, &size);
    uint32_t value = 0;
    if ((client->result == TUMBLE_OK) && (size <= TUMBLE_SDO_EXPEDITED)) {
        for (uint8_t i = 0; i < size; i++) {
            value |= (uint32_t)data[i] << (8U * (uint32_t)i);
        }
    }
    return value;
}

uint64_t tumble_sdo_client_next_us(const tumble_sdo_client_t *client)
{
    return client->request_due ? 0U : client->deadline_us;
}
