/* pdo_mapping.h - what the two files of the PDO service share; private to canopen. */
#ifndef TUMBLE_CANOPEN_PDO_MAPPING_H
#define TUMBLE_CANOPEN_PDO_MAPPING_H

#include "canopen/pdo.h"

/* Bit 31 of the COB-ID is clear: the PDO exists. */
static inline bool tumble_pdo_is_valid(const tumble_pdo_t *pdo)
{
    return (pdo->cob_id & TUMBLE_PDO_INVALID) == 0U;
}

#endif
