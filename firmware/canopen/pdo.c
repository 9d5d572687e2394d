#include "canopen/pdo.h"

#include "canopen/pdo_mapping.h"

#include <string.h>

#define US_PER_MS 1000U
#define INHIBIT_UNIT_US 100U

void tumble_pdo_init(tumble_pdos_t *pdos)
{
    (void)memset(pdos, 0, sizeof *pdos);
    for (uint8_t i = 0; i < TUMBLE_MAX_RECEIVE_PDOS; i++) {
        pdos->receive[i].cob_id = TUMBLE_PDO_INVALID;
        pdos->receive[i].type = TUMBLE_PDO_EVENT_PROFILE;
    }
    for (uint8_t i = 0; i < TUMBLE_MAX_TRANSMIT_PDOS; i++) {
        pdos->transmit[i].pdo.cob_id = TUMBLE_PDO_INVALID;
        pdos->transmit[i].pdo.type = TUMBLE_PDO_EVENT_PROFILE;
        pdos->transmit[i].event_us = TUMBLE_NEVER;
    }
}

static bool in_use(const tumble_pdo_t *pdo)
{
    return tumble_pdo_is_valid(pdo) && (pdo->count > 0U);
}

void tumble_pdo_trigger(tumble_pdos_t *pdos, uint8_t number)
{
    if (number < TUMBLE_MAX_TRANSMIT_PDOS) {
        pdos->transmit[number].pdo.due = true;
    }
}

void tumble_pdo_start(tumble_pdos_t *pdos)
{
    for (uint8_t i = 0; i < TUMBLE_MAX_TRANSMIT_PDOS; i++) {
        pdos->transmit[i].pdo.due = true;
    }
}

bool tumble_pdo_any_fault(const tumble_pdos_t *pdos)
{
    bool fault = false;

    for (uint8_t i = 0; i < TUMBLE_MAX_RECEIVE_PDOS; i++) {
        fault = fault || pdos->receive[i].fault;
    }
    return fault;
}

/* Write the mapped values, each under the dictionary's rules; one that is refused does not stop the others. */
static void unpack(tumble_pdos_t *pdos, const tumble_pdo_t *pdo, const tumble_dictionary_t *dictionary,
                   const uint8_t *data)
{
    uint8_t at = 0;

    for (uint8_t i = 0; i < pdo->count; i++) {
        const tumble_entry_t entry = tumble_pdo_mapped(dictionary, pdo, i);

        if (tumble_dictionary_write(dictionary, &entry, &data[at], entry.size) != TUMBLE_ABORT_NONE) {
            tumble_count_u16(&pdos->refused);
        }
        at = (uint8_t)(at + entry.size);
    }
}

static tumble_pdo_outcome_t take(tumble_pdos_t *pdos, tumble_pdo_t *pdo, const tumble_dictionary_t *dictionary,
                                 const tumble_can_frame_t *frame)
{
    pdo->fault = frame->length < pdo->length;
    if (pdo->fault) {
        tumble_count_u16(&pdos->too_short);
        return TUMBLE_PDO_TOO_SHORT;
    }
    unpack(pdos, pdo, dictionary, frame->data);
    return TUMBLE_PDO_TAKEN;
}

tumble_pdo_outcome_t tumble_pdo_receive(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary,
                                        const tumble_can_frame_t *frame, uint8_t *number)
{
    for (uint8_t i = 0; i < TUMBLE_MAX_RECEIVE_PDOS; i++) {
        tumble_pdo_t *pdo = &pdos->receive[i];

        if (in_use(pdo) && ((pdo->cob_id & TUMBLE_CAN_MAX_ID) == frame->id)) {
            if (number != NULL) {
                *number = i;
            }
            return take(pdos, pdo, dictionary, frame);
        }
    }
    return TUMBLE_PDO_NOT_MINE;
}

/* The present values. A value that its owner refuses to give is sent as zeros, so that the others keep their places. */
static void pack(const tumble_pdo_t *pdo, const tumble_dictionary_t *dictionary, tumble_can_frame_t *frame)
{
    (void)memset(frame, 0, sizeof *frame);
    frame->id = (uint16_t)(pdo->cob_id & TUMBLE_CAN_MAX_ID);
    for (uint8_t i = 0; i < pdo->count; i++) {
        const tumble_entry_t entry = tumble_pdo_mapped(dictionary, pdo, i);
        uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
        uint8_t size;

        if (tumble_dictionary_read(dictionary, &entry, bytes, &size) == TUMBLE_ABORT_NONE) {
            (void)memcpy(&frame->data[frame->length], bytes, size);
        }
        frame->length = (uint8_t)(frame->length + entry.size);
    }
}

static tumble_status_t send(tumble_transmit_pdo_t *transmit, const tumble_dictionary_t *dictionary, tumble_link_t *link,
                            uint64_t now_us)
{
    tumble_can_frame_t frame;
    tumble_status_t status;

    pack(&transmit->pdo, dictionary, &frame);
    status = tumble_link_send(link, &frame);
    if (status == TUMBLE_OK) {
        transmit->pdo.due = false;
        transmit->earliest_us = now_us + ((uint64_t)transmit->inhibit_100us * INHIBIT_UNIT_US);
        transmit->event_us =
            (transmit->event_ms == 0U) ? TUMBLE_NEVER : (now_us + ((uint64_t)transmit->event_ms * US_PER_MS));
    }
    return status;
}

void tumble_pdo_step(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary, tumble_link_t *link, uint64_t now_us)
{
    tumble_status_t status = TUMBLE_OK;

    for (uint8_t i = 0; (i < TUMBLE_MAX_TRANSMIT_PDOS) && (status == TUMBLE_OK); i++) {
        tumble_transmit_pdo_t *transmit = &pdos->transmit[i];
        bool due = transmit->pdo.due || (now_us >= transmit->event_us);

        if (in_use(&transmit->pdo) && due && (now_us >= transmit->earliest_us)) {
            status = send(transmit, dictionary, link, now_us);
        }
    }
}

/* When a PDO in use is to go: its event, but not before its inhibit time is over. */
static uint64_t due_us(const tumble_transmit_pdo_t *transmit)
{
    uint64_t wanted_us = transmit->pdo.due ? 0U : transmit->event_us;

    return (wanted_us < transmit->earliest_us) ? transmit->earliest_us : wanted_us;
}

uint64_t tumble_pdo_next_us(const tumble_pdos_t *pdos)
{
    uint64_t next_us = TUMBLE_NEVER;

    for (uint8_t i = 0; i < TUMBLE_MAX_TRANSMIT_PDOS; i++) {
        const tumble_transmit_pdo_t *transmit = &pdos->transmit[i];

        if (in_use(&transmit->pdo) && (due_us(transmit) < next_us)) {
            next_us = due_us(transmit);
        }
    }
    return next_us;
}
