/* options.h - the command line of tumble-gateway. */
#ifndef TUMBLE_GATEWAY_OPTIONS_H
#define TUMBLE_GATEWAY_OPTIONS_H

#include "arguments.h"
#include "gateway.h"
#include "serial.h"

#include <stdbool.h>

#define GATEWAY_HOST_BYTES 256U
#define GATEWAY_PORT_BYTES 8U

typedef struct {
    gateway_settings_t settings;
    const char *can;
    bool has_tcp;
    char host[GATEWAY_HOST_BYTES];
    char port[GATEWAY_PORT_BYTES];
    bool has_serial;
    gateway_serial_settings_t serial;
} gateway_options_t;

/* As arguments_read. */
int gateway_options_read(gateway_options_t *options, int count, char *arguments[]);

#endif
