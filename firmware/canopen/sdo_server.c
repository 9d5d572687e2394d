#include "canopen/sdo.h"
#include "canopen/sdo_frame.h"
#include "core/bytes.h"
#include "core/one_copy.h"

#include <string.h>

#define CONSUMER_TIME 0x1016U
#define PRODUCER_TIME 0x1017U
#define ERROR_BEHAVIOUR 0x1029U
#define RECEIVE_PDO 0x1400U
#define TRANSMIT_PDO 0x1800U
#define HELD_PDOS 0xFDFEU /* their first two and the mappings of these, 1600h and 1A00h */

void tumble_sdo_server_init(tumble_sdo_server_t *server, uint16_t response_id)
{
    (void)memset(server, 0, sizeof *server);
    server->response_id = response_id;
    server->deadline_us = TUMBLE_NEVER;
}

TUMBLE_ONE_COPY static void end_transfer(tumble_sdo_server_t *server)
{
    server->transfer = (uint8_t)TUMBLE_SDO_IDLE;
    server->deadline_us = TUMBLE_NEVER;
}

void tumble_sdo_server_drop(tumble_sdo_server_t *server)
{
    if (server->transfer != (uint8_t)TUMBLE_SDO_IDLE) {
        tumble_count_u16(&server->aborted);
    }
    end_transfer(server);
    server->answer_due = false;
}

/* An answer, all zero but for its command. */
static void answer(tumble_sdo_server_t *server, uint8_t command)
{
    (void)memset(server->answer, 0, sizeof server->answer);
    server->answer[0] = command;
    server->answer_due = true;
}

static void answer_with_object(tumble_sdo_server_t *server, uint8_t command)
{
    answer(server, command);
    tumble_put_u16(&server->answer[1], server->index);
    server->answer[3] = server->subindex;
}

static void refuse(tumble_sdo_server_t *server, tumble_abort_t reason)
{
    end_transfer(server);
    tumble_count_u16(&server->aborted);
    answer_with_object(server, TUMBLE_SDO_ABORT);
    tumble_put_u32(&server->answer[4], (uint32_t)reason);
}

static void begin_segments(tumble_sdo_server_t *server, tumble_sdo_transfer_t transfer)
{
    server->transfer = (uint8_t)transfer;
    server->done = 0;
    server->toggle = 0;
}

/* Expedited for 1 to 4 bytes, else the first answer of a segmented upload. */
static void answer_upload(tumble_sdo_server_t *server)
{
    if ((server->size >= 1U) && (server->size <= TUMBLE_SDO_EXPEDITED)) {
        answer_with_object(server, tumble_sdo_expedited(TUMBLE_SDO_UPLOAD_ANSWER, server->size));
        (void)memcpy(&server->answer[4], server->bytes, server->size);
    } else {
        begin_segments(server, TUMBLE_SDO_UPLOAD);
        answer_with_object(server, TUMBLE_SDO_UPLOAD_ANSWER | TUMBLE_SDO_S);
        server->answer[4] = server->size;
    }
}

static void begin_upload(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary)
{
    tumble_entry_t entry;
    tumble_abort_t refusal = tumble_dictionary_find(dictionary, server->index, server->subindex, &entry);
    if (refusal == TUMBLE_ABORT_NONE) {
        refusal = tumble_dictionary_read(dictionary, &entry, server->bytes, &server->size);
    }
    if (refusal == TUMBLE_ABORT_NONE) {
        answer_upload(server);
    } else {
        refuse(server, refusal);
    }
}

static void send_segment(tumble_sdo_server_t *server)
{
    uint8_t rest = (uint8_t)(server->size - server->done);
    uint8_t length = (rest < TUMBLE_SDO_SEGMENT) ? rest : TUMBLE_SDO_SEGMENT;
    uint8_t last = (length == rest) ? TUMBLE_SDO_C : 0U;
    answer(server, (uint8_t)(server->toggle | ((TUMBLE_SDO_SEGMENT - length) << 1) | last));
    (void)memcpy(&server->answer[1], &server->bytes[server->done], length);
    server->done = (uint8_t)(server->done + length);
    server->toggle ^= TUMBLE_SDO_TOGGLE;
    if (last != 0U) {
        end_transfer(server);
    }
}

/* What a stop depends on: who watches whom, the PDOs of the node's own parts, and the objects that these carry. */
static bool is_held(const tumble_entry_t *entry)
{
    const unsigned pdo = entry->index & HELD_PDOS;
    return (entry->home == TUMBLE_HOME_OTHER) || (entry->index == CONSUMER_TIME) || (entry->index == PRODUCER_TIME) ||
           (entry->index == ERROR_BEHAVIOUR) || (pdo == RECEIVE_PDO) || (pdo == TRANSMIT_PDO);
}

/* The only place that asks for the level: everything from outside comes through here, and nothing else does. */
static bool is_of_this_level(const tumble_sdo_server_t *server)
{
    return server->service || ((server->entry.access & TUMBLE_ACCESS_SERVICE) == 0U);
}

static void write_value(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary, const uint8_t *bytes,
                        uint8_t size)
{
    tumble_abort_t refusal = TUMBLE_ABORT_DEVICE_STATE;
    if ((!server->held || !is_held(&server->entry)) && is_of_this_level(server)) {
        refusal = tumble_dictionary_write(dictionary, &server->entry, bytes, size);
    }
    if (refusal == TUMBLE_ABORT_LATER) {
        server->transfer = (uint8_t)TUMBLE_SDO_LATER;
        server->deadline_us = TUMBLE_NEVER;
        server->answer_due = false; /* it is ready, should it be good */
    } else if (refusal != TUMBLE_ABORT_NONE) {
        refuse(server, refusal);
    } else {
        /* written */
    }
}

void tumble_sdo_server_answer(tumble_sdo_server_t *server, tumble_abort_t refusal)
{
    if (server->transfer != (uint8_t)TUMBLE_SDO_LATER) {
        return;
    }
    if (refusal == TUMBLE_ABORT_NONE) {
        end_transfer(server);
        server->answer_due = true;
    } else {
        refuse(server, refusal);
    }
}

/* Up to four bytes in the request itself; without a size they are as many as the object has. */
static void download_expedited(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary,
                               const tumble_can_frame_t *frame)
{
    uint8_t command = frame->data[0];
    uint8_t size = TUMBLE_SDO_EXPEDITED;
    if ((command & TUMBLE_SDO_S) != 0U) {
        size = (uint8_t)(TUMBLE_SDO_EXPEDITED - ((command >> 2) & 3U));
    } else if (server->entry.size < size) {
        size = server->entry.size;
    } else {
        /* all four */
    }
    answer_with_object(server, TUMBLE_SDO_DOWNLOAD_ANSWER);
    write_value(server, dictionary, &frame->data[4], size);
}

static void begin_segmented_download(tumble_sdo_server_t *server, const tumble_can_frame_t *frame)
{
    bool announced = (frame->data[0] & TUMBLE_SDO_S) != 0U;
    uint32_t size = announced ? tumble_get_u32(&frame->data[4]) : server->entry.size;
    tumble_abort_t refusal = tumble_dictionary_accepts(&server->entry, size);
    if (refusal == TUMBLE_ABORT_NONE) {
        begin_segments(server, TUMBLE_SDO_DOWNLOAD);
        server->size = announced ? (uint8_t)size : 0U;
        answer_with_object(server, TUMBLE_SDO_DOWNLOAD_ANSWER);
    } else {
        refuse(server, refusal);
    }
}

static void begin_download(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary,
                           const tumble_can_frame_t *frame)
{
    const tumble_abort_t refusal = tumble_dictionary_find(dictionary, server->index, server->subindex, &server->entry);
    if (refusal != TUMBLE_ABORT_NONE) {
        refuse(server, refusal);
    } else if ((frame->data[0] & TUMBLE_SDO_E) != 0U) {
        download_expedited(server, dictionary, frame);
    } else {
        begin_segmented_download(server, frame);
    }
}

static void end_download(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary)
{
    if ((server->size != 0U) && (server->done != server->size)) {
        refuse(server, TUMBLE_ABORT_LENGTH);
    } else {
        end_transfer(server);
        write_value(server, dictionary, server->bytes, server->done);
    }
}

static void take_segment(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary,
                         const tumble_can_frame_t *frame)
{
    uint8_t command = frame->data[0];
    uint8_t length = (uint8_t)(TUMBLE_SDO_SEGMENT - ((command >> 1) & 7U));
    uint8_t room = (server->size != 0U) ? server->size : server->entry.size;
    if (length > (room - server->done)) {
        refuse(server, TUMBLE_ABORT_TOO_LONG);
        return;
    }
    (void)memcpy(&server->bytes[server->done], &frame->data[1], length);
    server->done = (uint8_t)(server->done + length);
    answer(server, (uint8_t)(TUMBLE_SDO_DOWNLOAD_SEGMENT_ANSWER | server->toggle));
    server->toggle ^= TUMBLE_SDO_TOGGLE;
    if ((command & TUMBLE_SDO_C) != 0U) {
        end_download(server, dictionary);
    }
}

/* A request for, or with, one segment of the transfer under way. */
static void segment(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary, const tumble_can_frame_t *frame,
                    tumble_sdo_transfer_t transfer)
{
    if (server->transfer == (uint8_t)TUMBLE_SDO_IDLE) {
        server->index = 0;
        server->subindex = 0;
        refuse(server, TUMBLE_ABORT_COMMAND);
    } else if (server->transfer != (uint8_t)transfer) {
        refuse(server, TUMBLE_ABORT_COMMAND);
    } else if ((frame->data[0] & TUMBLE_SDO_TOGGLE) != server->toggle) {
        refuse(server, TUMBLE_ABORT_TOGGLE);
    } else if (transfer == TUMBLE_SDO_UPLOAD) {
        send_segment(server);
    } else {
        take_segment(server, dictionary, frame);
    }
}

/* The first request of a transfer names the object; it replaces a transfer that was left unfinished. */
static void name_object(tumble_sdo_server_t *server, const tumble_can_frame_t *frame)
{
    if (server->transfer != (uint8_t)TUMBLE_SDO_IDLE) {
        end_transfer(server);
        tumble_count_u16(&server->aborted);
    }
    server->index = tumble_get_u16(&frame->data[1]);
    server->subindex = frame->data[3];
}

static void serve(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary, const tumble_can_frame_t *frame)
{
    switch (frame->data[0] & TUMBLE_SDO_COMMAND_MASK) {
    case TUMBLE_SDO_DOWNLOAD_SEGMENT_REQUEST:
        segment(server, dictionary, frame, TUMBLE_SDO_DOWNLOAD);
        break;
    case TUMBLE_SDO_UPLOAD_SEGMENT_REQUEST:
        segment(server, dictionary, frame, TUMBLE_SDO_UPLOAD);
        break;
    case TUMBLE_SDO_DOWNLOAD_REQUEST:
        name_object(server, frame);
        begin_download(server, dictionary, frame);
        break;
    case TUMBLE_SDO_UPLOAD_REQUEST:
        name_object(server, frame);
        begin_upload(server, dictionary);
        break;
    default: /* block transfer, and a command that nobody knows */
        name_object(server, frame);
        refuse(server, TUMBLE_ABORT_COMMAND);
        break;
    }
}

static bool is_abort(const tumble_can_frame_t *frame)
{
    return (frame->data[0] & TUMBLE_SDO_COMMAND_MASK) == TUMBLE_SDO_ABORT;
}

void tumble_sdo_server_receive(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary,
                               const tumble_can_frame_t *frame, uint64_t now_us)
{
    if ((frame->length != TUMBLE_CAN_MAX_BYTES) || (server->answer_due && !is_abort(frame))) {
        tumble_count_u16(&server->dropped);
    } else if (is_abort(frame)) {
        tumble_sdo_server_drop(server);
    } else {
        serve(server, dictionary, frame);
        if ((server->transfer == (uint8_t)TUMBLE_SDO_UPLOAD) || (server->transfer == (uint8_t)TUMBLE_SDO_DOWNLOAD)) {
            server->deadline_us = now_us + TUMBLE_SDO_SERVER_TIMEOUT_US;
        }
    }
}

void tumble_sdo_server_step(tumble_sdo_server_t *server, tumble_link_t *link, uint64_t now_us)
{
    if (now_us >= server->deadline_us) {
        refuse(server, TUMBLE_ABORT_TIMEOUT);
    }
    if (server->answer_due) {
        server->answer_due =
            tumble_link_send_bytes(link, server->response_id, server->answer, sizeof server->answer) != TUMBLE_OK;
    }
}

uint64_t tumble_sdo_server_next_us(const tumble_sdo_server_t *server)
{
    return server->answer_due ? 0U : server->deadline_us;
}
