/* serial.h - Modbus RTU on a serial line, opened and set up by libmodbus; its one client is the line's master.
 *
 * Frames end where their own length and CRC say so. What fits neither a request nor an answer of another unit waits for
 * a gap on the line and is then a frame, if its CRC is right, or dropped and counted. */
#ifndef TUMBLE_GATEWAY_SERIAL_H
#define TUMBLE_GATEWAY_SERIAL_H

#include "client.h"

#include <modbus/modbus.h>

#define GATEWAY_DEVICE_BYTES 256U

typedef struct {
    char device[GATEWAY_DEVICE_BYTES];
    int baud;
    char parity; /* 'N', 'E', 'O' */
} gateway_serial_settings_t;

typedef struct {
    modbus_t *line;
    uint64_t gap_us;    /* silence that ends whatever has come */
    uint64_t heard_us;  /* the last byte */
    uint64_t reopen_us; /* after a fault */
    gateway_stream_t stream;
} gateway_serial_t;

/* False: errno says why; nothing stays open. */
bool gateway_serial_open(gateway_serial_t *serial, const gateway_serial_settings_t *settings);

/* Take what has come, answer, send what goes; open a device anew that went away. `hung_up`: the system says that it has
 * gone. */
void gateway_serial_step(gateway_serial_t *serial, gateway_t *gateway, bool hung_up, uint64_t now_us);

uint32_t gateway_serial_events(const gateway_serial_t *serial);

/* When step is due if nothing comes before. */
uint64_t gateway_serial_next_us(const gateway_serial_t *serial);

void gateway_serial_close(gateway_serial_t *serial, gateway_t *gateway);

#endif
