/* listener.h - the TCP socket that clients come to. */
#ifndef TUMBLE_GATEWAY_LISTENER_H
#define TUMBLE_GATEWAY_LISTENER_H

#include "client.h"

#include <stddef.h>

/* Listen at a host (name or address) and port ("0": any free one). Returns the descriptor, or -1 with `what` saying
 * why. */
int gateway_listen(const char *host, const char *port, const char **what);

/* Where it listens, as HOST:PORT. */
void gateway_listener_name(int listener, char *name, size_t size);

/* The next client, ready for use, and who it is; -1: there is none. Then `is_short` says whether that is for want of
 * something that the system does not have now, such as descriptors: errno says of what. Clients still wait then, and
 * the listener stays readable. */
int gateway_accept(int listener, gateway_address_t *address, bool *is_short);

#endif
