/* server.h - tumble-gateway: its command line, and its loop: one thread that waits for the bus, the clients, the serial
 * line, and being told to end. */
#ifndef TUMBLE_GATEWAY_SERVER_H
#define TUMBLE_GATEWAY_SERVER_H

#include "arguments.h"
#include "serial.h"

#include <stdbool.h>

#define GATEWAY_TCP_BYTES 263U /* a name of 255, a colon, a port */

typedef struct {
    gateway_settings_t settings;
    const char *can;
    bool has_tcp;
    char tcp[GATEWAY_TCP_BYTES]; /* into which the next two point */
    const char *host;
    const char *port;
    bool has_serial;
    gateway_serial_settings_t serial;
} gateway_options_t;

/* As arguments_read. */
int gateway_options_read(gateway_options_t *options, int count, char *arguments[]);

/* Serve until SIGTERM or SIGINT. `can_fd` becomes readable when the port may have frames. One line on standard error
 * says where it listens, or why it cannot. Returns the exit code. */
int gateway_serve(const gateway_options_t *options, const tumble_port_t *port, int can_fd);

#endif
