/* server.h - the gateway's loop: one thread that waits for the bus, the clients, the serial line, and being told to
 * end. */
#ifndef TUMBLE_GATEWAY_SERVER_H
#define TUMBLE_GATEWAY_SERVER_H

#include "options.h"

/* Serve until SIGTERM or SIGINT. `can_fd` becomes readable when the port may have frames. One line on standard error
 * says where it listens, or why it cannot. Returns the exit code. */
int gateway_serve(const gateway_options_t *options, const tumble_port_t *port, int can_fd);

#endif
