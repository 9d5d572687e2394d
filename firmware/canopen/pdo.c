#include "canopen/pdo.h"

#include "core/one_copy.h"

#include <stddef.h>
#include <string.h>

#define US_PER_MS 1000U
#define INHIBIT_UNIT_US 100U

/* The four areas of objects, 512 PDOs each. */
#define AREA_MASK 0xFE00U
#define RECEIVE_COMMUNICATION 0x1400U
#define RECEIVE_MAPPING 0x1600U
#define TRANSMIT_COMMUNICATION 0x1800U
#define TRANSMIT_MAPPING 0x1A00U
#define MAPPING_AWAY 0x200U /* from a communication parameter to its mapping */

/* Subindices of a communication parameter. */
#define SUB_COUNT 0U
#define SUB_COB_ID 1U
#define SUB_TYPE 2U
#define SUB_INHIBIT 3U
#define SUB_EVENT 5U

#define COB_ID_UNUSED_BITS 0x3FFFF800U /* a 29-bit identifier, or its mark */
#define MAP_BITS 8U

/* Bit 31 of the COB-ID is clear: the PDO exists. */
static bool is_valid(const tumble_pdo_t *pdo)
{
    return (pdo->cob_id & TUMBLE_PDO_INVALID) == 0U;
}

/* The mapped object in a slot that is set. */
static tumble_entry_t mapped(const tumble_dictionary_t *dictionary, const tumble_pdo_t *pdo, uint32_t slot)
{
    const uint8_t place = pdo->place[slot];
    const uint16_t index = tumble_dictionary_row(dictionary, place)->index;
    return tumble_dictionary_entry(dictionary, place, index, pdo->subindex[slot]);
}

/* Parameters. */

static bool is_transmit(uint16_t index)
{
    return (index & TRANSMIT_COMMUNICATION) == TRANSMIT_COMMUNICATION;
}

TUMBLE_ONE_COPY static bool is_mapping(uint16_t index)
{
    return ((index & AREA_MASK) == RECEIVE_MAPPING) || ((index & AREA_MASK) == TRANSMIT_MAPPING);
}

/* The PDO that an object belongs to. A receive PDO has no `transmit`, and so neither inhibit time nor event timer; with
 * no `pdo` either, this node does not have it. */
typedef struct {
    tumble_pdo_t *pdo;
    tumble_transmit_pdo_t *transmit;
} found_t;

static found_t find(tumble_pdos_t *pdos, uint16_t index)
{
    const uint32_t number = index & (uint32_t)(uint16_t)~AREA_MASK;
    if (is_transmit(index) && (number < TUMBLE_MAX_TRANSMIT_PDOS)) {
        return (found_t){&pdos->transmit[number].pdo, &pdos->transmit[number]};
    }
    const bool receives = !is_transmit(index) && (number < TUMBLE_MAX_RECEIVE_PDOS);
    return (found_t){receives ? &pdos->receive[number] : NULL, NULL};
}

static uint32_t map_value(const tumble_dictionary_t *dictionary, const tumble_pdo_t *pdo, uint8_t slot)
{
    if ((pdo->written & (1U << slot)) == 0U) {
        return 0;
    }
    const tumble_entry_t entry = mapped(dictionary, pdo, slot);
    return TUMBLE_MAP(entry.index, entry.subindex, entry.size * MAP_BITS);
}

static tumble_abort_t read_mapping(const tumble_pdo_t *pdo, const tumble_dictionary_t *dictionary, uint8_t subindex,
                                   uint32_t *value)
{
    if (subindex > TUMBLE_MAX_MAPPED) {
        return TUMBLE_ABORT_NO_SUBINDEX;
    }
    *value = (subindex == SUB_COUNT) ? pdo->count : map_value(dictionary, pdo, (uint8_t)(subindex - 1U));
    return TUMBLE_ABORT_NONE;
}

static tumble_abort_t read_communication(const found_t *found, uint8_t subindex, uint32_t *value)
{
    const tumble_transmit_pdo_t *transmit = found->transmit;
    if (subindex == SUB_COUNT) {
        *value = (transmit != NULL) ? SUB_EVENT : SUB_TYPE;
    } else if (subindex == SUB_COB_ID) {
        *value = found->pdo->cob_id;
    } else if (subindex == SUB_TYPE) {
        *value = found->pdo->type;
    } else if ((transmit != NULL) && (subindex == SUB_INHIBIT)) {
        *value = transmit->inhibit_100us;
    } else if ((transmit != NULL) && (subindex == SUB_EVENT)) {
        *value = transmit->event_ms;
    } else {
        return TUMBLE_ABORT_NO_SUBINDEX;
    }
    return TUMBLE_ABORT_NONE;
}

tumble_abort_t tumble_pdo_read_parameter(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary, uint16_t index,
                                         uint8_t subindex, uint32_t *value)
{
    const found_t found = find(pdos, index);
    if (found.pdo == NULL) {
        return TUMBLE_ABORT_NO_OBJECT;
    }
    return is_mapping(index) ? read_mapping(found.pdo, dictionary, subindex, value)
                             : read_communication(&found, subindex, value);
}

/* Identifiers that CiA 301 (table 40) keeps from configurable objects. */
static bool is_reserved(uint32_t id)
{
    return (id <= 0x07FU) || ((id >= 0x101U) && (id <= 0x180U)) || ((id >= 0x581U) && (id <= 0x5FFU)) ||
           ((id >= 0x601U) && (id <= 0x67FU)) || ((id >= 0x6E0U) && (id <= 0x6FFU)) || (id >= 0x701U);
}

/* While a PDO is enabled its identifier cannot change; disabling it is always possible. A transmit PDO that is enabled
 * is due once. */
static tumble_abort_t write_cob_id(tumble_pdo_t *pdo, uint32_t value)
{
    const bool enable = (value & TUMBLE_PDO_INVALID) == 0U;
    if (((value & COB_ID_UNUSED_BITS) != 0U) || (enable && is_reserved(value & TUMBLE_CAN_MAX_ID))) {
        return TUMBLE_ABORT_VALUE;
    }
    if (enable && is_valid(pdo) && (value != pdo->cob_id)) {
        return TUMBLE_ABORT_DEVICE_STATE;
    }
    pdo->due = enable && (pdo->due || !is_valid(pdo));
    pdo->cob_id = value;
    pdo->fault = false;
    return TUMBLE_ABORT_NONE;
}

static tumble_abort_t write_type(tumble_pdo_t *pdo, uint32_t value)
{
    if ((value != TUMBLE_PDO_EVENT_MAKER) && (value != TUMBLE_PDO_EVENT_PROFILE)) {
        return TUMBLE_ABORT_VALUE;
    }
    pdo->type = (uint8_t)value;
    return TUMBLE_ABORT_NONE;
}

static tumble_abort_t write_inhibit(tumble_transmit_pdo_t *transmit, uint32_t value)
{
    if (is_valid(&transmit->pdo)) {
        return TUMBLE_ABORT_DEVICE_STATE;
    }
    transmit->inhibit_100us = (uint16_t)value;
    transmit->earliest_us = 0;
    return TUMBLE_ABORT_NONE;
}

/* A new time starts with a PDO at once. */
static tumble_abort_t write_event(tumble_transmit_pdo_t *transmit, uint32_t value)
{
    transmit->event_ms = (uint16_t)value;
    transmit->event_us = (value == 0U) ? TUMBLE_NEVER : 0U;
    return TUMBLE_ABORT_NONE;
}

static tumble_abort_t write_communication(const found_t *found, uint8_t subindex, uint32_t value)
{
    switch (subindex) {
    case SUB_COUNT:
        return TUMBLE_ABORT_READ_ONLY;
    case SUB_COB_ID:
        return write_cob_id(found->pdo, value);
    case SUB_TYPE:
        return write_type(found->pdo, value);
    case SUB_INHIBIT:
        return (found->transmit != NULL) ? write_inhibit(found->transmit, value) : TUMBLE_ABORT_NO_SUBINDEX;
    case SUB_EVENT:
        return (found->transmit != NULL) ? write_event(found->transmit, value) : TUMBLE_ABORT_NO_SUBINDEX;
    default:
        return TUMBLE_ABORT_NO_SUBINDEX;
    }
}

/* May the object at this place be mapped, in this direction and with the bits that the map value says? */
static bool is_mappable(const tumble_dictionary_t *dictionary, uint8_t place, uint32_t value, bool transmit)
{
    const uint8_t needed = transmit ? TUMBLE_ACCESS_MAP_TRANSMIT : TUMBLE_ACCESS_MAP_RECEIVE;
    tumble_entry_t entry =
        tumble_dictionary_entry(dictionary, place, (uint16_t)(value >> 16), (uint8_t)((value >> 8) & 0xFFU));
    return ((entry.access & needed) != 0U) && ((value & 0xFFU) == (entry.size * MAP_BITS));
}

static tumble_abort_t write_slot(tumble_pdo_t *pdo, const tumble_dictionary_t *dictionary, bool transmit, uint8_t slot,
                                 uint32_t value)
{
    const uint8_t bit = (uint8_t)(1U << slot);
    const uint8_t subindex = (uint8_t)((value >> 8) & 0xFFU);
    uint8_t place;
    if (value == 0U) {
        pdo->written &= (uint8_t)~bit;
        return TUMBLE_ABORT_NONE;
    }
    const tumble_abort_t refusal = tumble_dictionary_place(dictionary, (uint16_t)(value >> 16), subindex, &place);
    if (refusal != TUMBLE_ABORT_NONE) {
        return refusal;
    }
    if (!is_mappable(dictionary, place, value, transmit)) {
        return TUMBLE_ABORT_NOT_MAPPABLE;
    }
    pdo->place[slot] = place;
    pdo->subindex[slot] = subindex;
    pdo->written |= bit;
    return TUMBLE_ABORT_NONE;
}

/* Take so many slots into use: all of them must be set, and fit one frame together. */
static tumble_abort_t write_count(tumble_pdo_t *pdo, const tumble_dictionary_t *dictionary, uint32_t value)
{
    uint32_t length = 0;
    if (value > TUMBLE_MAX_MAPPED) {
        return TUMBLE_ABORT_VALUE;
    }
    for (uint32_t slot = 0; slot < value; slot++) {
        if ((pdo->written & (1U << slot)) == 0U) {
            return TUMBLE_ABORT_NOT_MAPPABLE;
        }
        length += tumble_dictionary_row(dictionary, pdo->place[slot])->size;
    }
    if (length > TUMBLE_CAN_MAX_BYTES) {
        return TUMBLE_ABORT_MAP_LENGTH;
    }
    pdo->count = (uint8_t)value;
    pdo->length = (uint8_t)length;
    return TUMBLE_ABORT_NONE;
}

static tumble_abort_t write_mapping(tumble_pdo_t *pdo, const tumble_dictionary_t *dictionary, bool transmit,
                                    uint8_t subindex, uint32_t value)
{
    if (subindex > TUMBLE_MAX_MAPPED) {
        return TUMBLE_ABORT_NO_SUBINDEX;
    }
    if (is_valid(pdo) || ((subindex != SUB_COUNT) && (pdo->count != 0U))) {
        return TUMBLE_ABORT_DEVICE_STATE;
    }
    return (subindex == SUB_COUNT) ? write_count(pdo, dictionary, value)
                                   : write_slot(pdo, dictionary, transmit, (uint8_t)(subindex - 1U), value);
}

/* Has another PDO of this node this identifier? Whoever receives it would take our frame for the other one's. */
static bool is_taken(const tumble_pdos_t *pdos, const tumble_pdo_t *pdo, uint32_t value)
{
    bool taken = false;
    for (unsigned i = 0; i < (TUMBLE_MAX_TRANSMIT_PDOS + TUMBLE_MAX_RECEIVE_PDOS); i++) {
        const tumble_pdo_t *other =
            (i < TUMBLE_MAX_TRANSMIT_PDOS) ? &pdos->transmit[i].pdo : &pdos->receive[i - TUMBLE_MAX_TRANSMIT_PDOS];
        taken = taken || ((other != pdo) && is_valid(other) && (((other->cob_id ^ value) & TUMBLE_CAN_MAX_ID) == 0U));
    }
    return taken && ((value & TUMBLE_PDO_INVALID) == 0U);
}

tumble_abort_t tumble_pdo_write_parameter(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary, uint16_t index,
                                          uint8_t subindex, uint32_t value)
{
    const found_t found = find(pdos, index);
    if (found.pdo == NULL) {
        return TUMBLE_ABORT_NO_OBJECT;
    }
    if (!is_mapping(index) && (subindex == SUB_COB_ID) && is_taken(pdos, found.pdo, value)) {
        return TUMBLE_ABORT_VALUE;
    }
    return is_mapping(index) ? write_mapping(found.pdo, dictionary, found.transmit != NULL, subindex, value)
                             : write_communication(&found, subindex, value);
}

/* The steps of a setup: disable, no objects, the objects, their number, the rest, enable. */
#define STEP_DISABLE 0U
#define STEP_EMPTY 1U
#define STEP_FIRST_OBJECT 2U
#define STEP_COUNT (STEP_FIRST_OBJECT + TUMBLE_MAX_MAPPED)
#define STEP_TYPE (STEP_COUNT + 1U)
#define STEP_INHIBIT (STEP_COUNT + 2U)
#define STEP_EVENT (STEP_COUNT + 3U)

static void setup_communication(const tumble_pdo_setup_t *setup, uint8_t step, tumble_object_write_t *write)
{
    const uint8_t transmit_size = is_transmit(write->index) ? 2U : 0U;
    if (step == STEP_TYPE) {
        write->subindex = SUB_TYPE;
        write->size = 1;
        write->value = setup->type;
    } else if (step == STEP_INHIBIT) {
        write->subindex = SUB_INHIBIT;
        write->size = transmit_size;
        write->value = setup->inhibit_100us;
    } else if (step == STEP_EVENT) {
        write->subindex = SUB_EVENT;
        write->size = transmit_size;
        write->value = setup->event_ms;
    } else {
        write->subindex = SUB_COB_ID;
        write->size = 4;
        write->value = setup->cob_id | ((step == STEP_DISABLE) ? TUMBLE_PDO_INVALID : 0U);
    }
}

static void setup_mapping(const tumble_pdo_setup_t *setup, uint8_t step, tumble_object_write_t *write)
{
    write->index = (uint16_t)(write->index + MAPPING_AWAY);
    write->subindex = SUB_COUNT;
    write->size = 1;
    if (step == STEP_EMPTY) {
        write->value = 0;
    } else if (step == STEP_COUNT) {
        write->value = setup->count;
    } else {
        const uint8_t slot = (uint8_t)(step - STEP_FIRST_OBJECT);
        write->subindex = (uint8_t)(slot + 1U);
        write->size = (slot < setup->count) ? 4U : 0U;
        write->value = setup->map[slot];
    }
}

void tumble_pdo_setup_write(const tumble_pdo_setup_t *setup, uint16_t index, uint8_t step, tumble_object_write_t *write)
{
    write->index = index;
    if ((step >= STEP_EMPTY) && (step <= STEP_COUNT)) {
        setup_mapping(setup, step, write);
    } else {
        setup_communication(setup, step, write);
    }
}

bool tumble_pdo_setup_stays(uint8_t step)
{
    return ((step >= STEP_FIRST_OBJECT) && (step <= STEP_COUNT)) || (step > STEP_EVENT);
}

/* Disabled first whatever the setup says, so that a refusal leaves it invalid. */
tumble_abort_t tumble_pdo_configure(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary,
                                    tumble_pdo_direction_t direction, uint8_t number, const tumble_pdo_setup_t *setup)
{
    const uint16_t base = (direction == TUMBLE_PDO_TRANSMIT) ? TRANSMIT_COMMUNICATION : RECEIVE_COMMUNICATION;
    tumble_object_write_t write = {(uint16_t)(base + number), SUB_COB_ID, 4, TUMBLE_PDO_INVALID | TUMBLE_PDO_NO_RTR};
    tumble_abort_t refusal = TUMBLE_ABORT_NONE;
    for (uint8_t step = STEP_DISABLE; (step < TUMBLE_PDO_SETUP_STEPS) && (refusal == TUMBLE_ABORT_NONE); step++) {
        if (step != STEP_DISABLE) {
            tumble_pdo_setup_write(setup, (uint16_t)(base + number), step, &write);
        }
        if (write.size != 0U) {
            refusal = tumble_pdo_write_parameter(pdos, dictionary, write.index, write.subindex, write.value);
        }
        if ((step == STEP_EMPTY) && (setup->count > TUMBLE_MAX_MAPPED)) {
            refusal = TUMBLE_ABORT_MAP_LENGTH;
        }
    }
    return refusal;
}

/* Frames. */

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
    return is_valid(pdo) && (pdo->count > 0U);
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
        const tumble_entry_t entry = mapped(dictionary, pdo, i);
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
        const tumble_entry_t entry = mapped(dictionary, pdo, i);
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
