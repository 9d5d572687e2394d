/* places.h - who gives way when all places are taken. Pure functions. */
#ifndef TUMBLE_GATEWAY_PLACES_H
#define TUMBLE_GATEWAY_PLACES_H

#include "client.h"

/* Who has asked something is left alone for so long, whether or not it asks more: it may poll once a second. */
#define GATEWAY_CALM_US 2000000U

/* The place that a newcomer from `address` gets: a free one; else that of the client that has been silent for longest,
 * of those whose address holds most. An address that holds two places more than the newcomer's gives one up even when
 * all its clients are busy, so that 32 clients of one address lock out nobody else; to others only an idle client gives
 * way, and nobody to an address that holds more than its own. GATEWAY_MAX_CLIENTS: there is none. */
uint32_t gateway_place_for(const gateway_client_t clients[GATEWAY_MAX_CLIENTS], const gateway_address_t *address,
                           uint64_t now_us);

#endif
