/* places.h - who gives way when all places are taken. Pure functions. */
#ifndef TUMBLE_GATEWAY_PLACES_H
#define TUMBLE_GATEWAY_PLACES_H

#include "client.h"

/* Who has asked something is left alone for so long, whether or not it asks more: it may poll once a second. */
#define GATEWAY_CALM_US 2000000U

/* The place that a newcomer from `address` gets: a free one; else that of the client that has been idle longest, of
 * those whose address holds most. Nobody gives way to an address that holds more than its own: whoever takes many
 * places loses them first, and cannot take those of others. GATEWAY_MAX_CLIENTS: there is none. */
uint32_t gateway_place_for(const gateway_client_t clients[GATEWAY_MAX_CLIENTS], const gateway_address_t *address,
                           uint64_t now_us);

#endif
