#include "canopen/pdo_mapping.h"

#include <stddef.h>

/* The four areas of objects, 512 PDOs each. */
#define AREA_MASK 0xFE00U
#define RECEIVE_COMMUNICATION 0x1400U
#define RECEIVE_MAPPING 0x1600U
#define TRANSMIT_COMMUNICATION 0x1800U
#define TRANSMIT_MAPPING 0x1A00U

/* Subindices of a communication parameter. */
#define SUB_COUNT 0U
#define SUB_COB_ID 1U
#define SUB_TYPE 2U
#define SUB_INHIBIT 3U
#define SUB_EVENT 5U

#define COB_ID_UNUSED_BITS 0x3FFFF800U /* a 29-bit identifier, or its mark */
#define MAP_BITS 8U

static bool is_transmit(uint16_t index)
{
    return (index & TRANSMIT_COMMUNICATION) == TRANSMIT_COMMUNICATION;
}

static bool is_mapping(uint16_t index)
{
    return ((index & AREA_MASK) == RECEIVE_MAPPING) || ((index & AREA_MASK) == TRANSMIT_MAPPING);
}

static uint8_t number_of(uint16_t index)
{
    return (uint8_t)(index & 0xFFU);
}

/* Does this node have the PDO that the object belongs to? */
static bool exists(uint16_t index)
{
    uint32_t number = index & (uint32_t)(uint16_t)~AREA_MASK;

    return number < (is_transmit(index) ? (uint32_t)TUMBLE_MAX_TRANSMIT_PDOS : (uint32_t)TUMBLE_MAX_RECEIVE_PDOS);
}

static uint32_t map_value(const tumble_dictionary_t *dictionary, const tumble_pdo_t *pdo, uint8_t slot)
{
    uint32_t value = 0;

    if ((pdo->written & (1U << slot)) != 0U) {
        const tumble_entry_t entry = tumble_pdo_mapped(dictionary, pdo, slot);

        value = TUMBLE_MAP(entry.index, entry.subindex, entry.size * MAP_BITS);
    }
    return value;
}

static tumble_abort_t read_mapping(const tumble_pdo_t *pdo, const tumble_dictionary_t *dictionary, uint8_t subindex,
                                   uint32_t *value)
{
    tumble_abort_t refusal = TUMBLE_ABORT_NONE;

    if (subindex == SUB_COUNT) {
        *value = pdo->count;
    } else if (subindex <= TUMBLE_MAX_MAPPED) {
        *value = map_value(dictionary, pdo, (uint8_t)(subindex - 1U));
    } else {
        refusal = TUMBLE_ABORT_NO_SUBINDEX;
    }
    return refusal;
}

/* `transmit` is null for a receive PDO, which has neither inhibit time nor event timer. */
static tumble_abort_t read_communication(const tumble_pdo_t *pdo, const tumble_transmit_pdo_t *transmit,
                                         uint8_t subindex, uint32_t *value)
{
    tumble_abort_t refusal = TUMBLE_ABORT_NONE;

    if (subindex == SUB_COUNT) {
        *value = (transmit != NULL) ? SUB_EVENT : SUB_TYPE;
    } else if (subindex == SUB_COB_ID) {
        *value = pdo->cob_id;
    } else if (subindex == SUB_TYPE) {
        *value = pdo->type;
    } else if ((transmit != NULL) && (subindex == SUB_INHIBIT)) {
        *value = transmit->inhibit_100us;
    } else if ((transmit != NULL) && (subindex == SUB_EVENT)) {
        *value = transmit->event_ms;
    } else {
        refusal = TUMBLE_ABORT_NO_SUBINDEX;
    }
    return refusal;
}

tumble_abort_t tumble_pdo_read_parameter(const tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary,
                                         uint16_t index, uint8_t subindex, uint32_t *value)
{
    const bool outward = is_transmit(index);
    const tumble_transmit_pdo_t *transmit;
    const tumble_pdo_t *pdo;

    if (!exists(index)) {
        return TUMBLE_ABORT_NO_OBJECT;
    }
    transmit = outward ? &pdos->transmit[number_of(index)] : NULL;
    pdo = outward ? &transmit->pdo : &pdos->receive[number_of(index)];
    return is_mapping(index) ? read_mapping(pdo, dictionary, subindex, value)
                             : read_communication(pdo, transmit, subindex, value);
}

/* Identifiers that CiA 301 (table 40) keeps from configurable objects. */
static bool is_reserved(uint32_t id)
{
    return (id <= 0x07FU) || ((id >= 0x101U) && (id <= 0x180U)) || ((id >= 0x581U) && (id <= 0x5FFU)) ||
           ((id >= 0x601U) && (id <= 0x67FU)) || ((id >= 0x6E0U) && (id <= 0x6FFU)) || (id >= 0x701U);
}

/* While the PDO exists its identifier stands; disabling it is always possible. A transmit PDO that begins to exist is
 * due once. */
static tumble_abort_t write_cob_id(tumble_pdo_t *pdo, uint32_t value)
{
    bool enable = (value & TUMBLE_PDO_INVALID) == 0U;
    tumble_abort_t refusal = TUMBLE_ABORT_NONE;

    if (((value & COB_ID_UNUSED_BITS) != 0U) || (enable && is_reserved(value & TUMBLE_CAN_MAX_ID))) {
        refusal = TUMBLE_ABORT_VALUE;
    } else if (enable && tumble_pdo_is_valid(pdo) && (value != pdo->cob_id)) {
        refusal = TUMBLE_ABORT_DEVICE_STATE;
    } else {
        pdo->due = enable && (pdo->due || !tumble_pdo_is_valid(pdo));
        pdo->cob_id = value;
        pdo->fault = false;
    }
    return refusal;
}

static tumble_abort_t write_type(tumble_pdo_t *pdo, uint32_t value)
{
    tumble_abort_t refusal = TUMBLE_ABORT_VALUE;

    if ((value == TUMBLE_PDO_EVENT_MAKER) || (value == TUMBLE_PDO_EVENT_PROFILE)) {
        pdo->type = (uint8_t)value;
        refusal = TUMBLE_ABORT_NONE;
    }
    return refusal;
}

static tumble_abort_t write_inhibit(tumble_transmit_pdo_t *transmit, uint32_t value)
{
    tumble_abort_t refusal = TUMBLE_ABORT_DEVICE_STATE;

    if (!tumble_pdo_is_valid(&transmit->pdo)) {
        transmit->inhibit_100us = (uint16_t)value;
        transmit->earliest_us = 0;
        refusal = TUMBLE_ABORT_NONE;
    }
    return refusal;
}

/* A new time starts with a PDO at once. */
static tumble_abort_t write_event(tumble_transmit_pdo_t *transmit, uint32_t value)
{
    transmit->event_ms = (uint16_t)value;
    transmit->event_us = (value == 0U) ? TUMBLE_NEVER : 0U;
    return TUMBLE_ABORT_NONE;
}

static tumble_abort_t write_communication(tumble_pdo_t *pdo, tumble_transmit_pdo_t *transmit, uint8_t subindex,
                                          uint32_t value)
{
    tumble_abort_t refusal = TUMBLE_ABORT_NO_SUBINDEX;

    if (subindex == SUB_COUNT) {
        refusal = TUMBLE_ABORT_READ_ONLY;
    } else if (subindex == SUB_COB_ID) {
        refusal = write_cob_id(pdo, value);
    } else if (subindex == SUB_TYPE) {
        refusal = write_type(pdo, value);
    } else if ((transmit != NULL) && (subindex == SUB_INHIBIT)) {
        refusal = write_inhibit(transmit, value);
    } else if ((transmit != NULL) && (subindex == SUB_EVENT)) {
        refusal = write_event(transmit, value);
    } else {
        /* no such parameter */
    }
    return refusal;
}

/* May the object at this place be mapped, in this direction and with the bits that the map value says? */
static bool is_mappable(const tumble_dictionary_t *dictionary, uint8_t place, uint32_t value, bool transmit)
{
    uint8_t needed = transmit ? TUMBLE_ACCESS_MAP_TRANSMIT : TUMBLE_ACCESS_MAP_RECEIVE;
    tumble_entry_t entry =
        tumble_dictionary_entry(dictionary, place, (uint16_t)(value >> 16), (uint8_t)((value >> 8) & 0xFFU));

    return ((entry.access & needed) != 0U) && ((value & 0xFFU) == (entry.size * MAP_BITS));
}

static tumble_abort_t write_slot(tumble_pdo_t *pdo, const tumble_dictionary_t *dictionary, bool transmit, uint8_t slot,
                                 uint32_t value)
{
    tumble_abort_t refusal = TUMBLE_ABORT_NONE;
    uint8_t bit = (uint8_t)(1U << slot);

    if (value == 0U) {
        pdo->written &= (uint8_t)~bit;
    } else {
        const uint16_t index = (uint16_t)(value >> 16);
        const uint8_t subindex = (uint8_t)((value >> 8) & 0xFFU);
        uint8_t place;

        refusal = tumble_dictionary_place(dictionary, index, subindex, &place);
        if (refusal != TUMBLE_ABORT_NONE) {
            /* no such object */
        } else if (!is_mappable(dictionary, place, value, transmit)) {
            refusal = TUMBLE_ABORT_NOT_MAPPABLE;
        } else {
            pdo->place[slot] = place;
            pdo->subindex[slot] = subindex;
            pdo->written |= bit;
        }
    }
    return refusal;
}

/* Take so many slots into use: all of them must be set, and fit one frame together. */
static tumble_abort_t write_count(tumble_pdo_t *pdo, const tumble_dictionary_t *dictionary, uint32_t value)
{
    uint32_t length = 0;

    if (value > TUMBLE_MAX_MAPPED) {
        return TUMBLE_ABORT_VALUE;
    }
    for (uint32_t slot = 0; slot < value; ++slot) {
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
    tumble_abort_t refusal;

    if (subindex > TUMBLE_MAX_MAPPED) {
        refusal = TUMBLE_ABORT_NO_SUBINDEX;
    } else if (tumble_pdo_is_valid(pdo) || ((subindex != SUB_COUNT) && (pdo->count != 0U))) {
        refusal = TUMBLE_ABORT_DEVICE_STATE;
    } else if (subindex == SUB_COUNT) {
        refusal = write_count(pdo, dictionary, value);
    } else {
        refusal = write_slot(pdo, dictionary, transmit, (uint8_t)(subindex - 1U), value);
    }
    return refusal;
}

tumble_abort_t tumble_pdo_write_parameter(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary, uint16_t index,
                                          uint8_t subindex, uint32_t value)
{
    const bool outward = is_transmit(index);
    tumble_transmit_pdo_t *transmit;
    tumble_pdo_t *pdo;

    if (!exists(index)) {
        return TUMBLE_ABORT_NO_OBJECT;
    }
    transmit = outward ? &pdos->transmit[number_of(index)] : NULL;
    pdo = outward ? &transmit->pdo : &pdos->receive[number_of(index)];
    return is_mapping(index) ? write_mapping(pdo, dictionary, outward, subindex, value)
                             : write_communication(pdo, transmit, subindex, value);
}

/* First object of a direction's communication parameter; its mapping is 200h further. */
static uint16_t communication_of(tumble_pdo_direction_t direction, uint8_t number)
{
    uint16_t base = (direction == TUMBLE_PDO_TRANSMIT) ? TRANSMIT_COMMUNICATION : RECEIVE_COMMUNICATION;

    return (uint16_t)(base + number);
}

static tumble_abort_t configure_mapping(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary, uint16_t mapping,
                                        const tumble_pdo_setup_t *setup)
{
    tumble_abort_t refusal = tumble_pdo_write_parameter(pdos, dictionary, mapping, SUB_COUNT, 0);

    for (uint8_t i = 0; (i < setup->count) && (refusal == TUMBLE_ABORT_NONE); ++i) {
        refusal = (i < TUMBLE_MAX_MAPPED)
                      ? tumble_pdo_write_parameter(pdos, dictionary, mapping, (uint8_t)(i + 1U), setup->map[i])
                      : TUMBLE_ABORT_MAP_LENGTH;
    }
    if (refusal == TUMBLE_ABORT_NONE) {
        refusal = tumble_pdo_write_parameter(pdos, dictionary, mapping, SUB_COUNT, setup->count);
    }
    return refusal;
}

tumble_abort_t tumble_pdo_configure(tumble_pdos_t *pdos, const tumble_dictionary_t *dictionary,
                                    tumble_pdo_direction_t direction, uint8_t number, const tumble_pdo_setup_t *setup)
{
    uint16_t index = communication_of(direction, number);
    tumble_abort_t refusal =
        tumble_pdo_write_parameter(pdos, dictionary, index, SUB_COB_ID, TUMBLE_PDO_INVALID | TUMBLE_PDO_NO_RTR);

    if (refusal == TUMBLE_ABORT_NONE) {
        refusal = configure_mapping(pdos, dictionary, (uint16_t)(index + 0x200U), setup);
    }
    if (refusal == TUMBLE_ABORT_NONE) {
        refusal = tumble_pdo_write_parameter(pdos, dictionary, index, SUB_TYPE, setup->type);
    }
    if ((refusal == TUMBLE_ABORT_NONE) && (direction == TUMBLE_PDO_TRANSMIT)) {
        (void)write_inhibit(&pdos->transmit[number], setup->inhibit_100us);
        (void)write_event(&pdos->transmit[number], setup->event_ms);
    }
    if (refusal == TUMBLE_ABORT_NONE) {
        refusal = tumble_pdo_write_parameter(pdos, dictionary, index, SUB_COB_ID, setup->cob_id);
    }
    return refusal;
}
