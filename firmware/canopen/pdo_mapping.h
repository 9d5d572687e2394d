/* pdo_mapping.h - what the two files of the PDO service share; private to canopen. */
#ifndef TUMBLE_CANOPEN_PDO_MAPPING_H
#define TUMBLE_CANOPEN_PDO_MAPPING_H

#include "canopen/pdo.h"

/* Bit 31 of the COB-ID is clear: the PDO exists. */
static inline bool tumble_pdo_is_valid(const tumble_pdo_t *pdo)
{
    return (pdo->cob_id & TUMBLE_PDO_INVALID) == 0U;
}

/* The mapped object in a slot that is set. */
static inline tumble_entry_t tumble_pdo_mapped(const tumble_dictionary_t *dictionary, const tumble_pdo_t *pdo,
                                               uint32_t slot)
{
    const uint8_t place = pdo->place[slot];

    const uint16_t index = tumble_dictionary_row(dictionary, place)->index;

    return tumble_dictionary_entry(dictionary, place, index, pdo->subindex[slot]);
}

#endif
