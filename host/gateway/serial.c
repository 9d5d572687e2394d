#define _POSIX_C_SOURCE 200809L

#include "serial.h"

#include <errno.h>
#include <sys/epoll.h>

#define US_PER_S 1000000U
#define BITS_OF_A_CHARACTER 11U
#define GAP_HALF_CHARACTERS 7U /* 3.5 characters */
#define LEAST_GAP_US 20000U    /* adapters hand over what they receive in portions up to 16 ms apart */
#define REOPEN_US 1000000U
#define LEAST_FRAME 4U

static bool connect_line(gateway_serial_t *serial)
{
    if (modbus_connect(serial->line) != 0) {
        return false;
    }
    serial->stream.fd = modbus_get_socket(serial->line);
    serial->stream.watched = 0;
    serial->stream.in_count = 0;
    serial->stream.out_count = 0;
    return true;
}

bool gateway_serial_open(gateway_serial_t *serial, const gateway_serial_settings_t *settings)
{
    const uint64_t gap_us =
        (uint64_t)GAP_HALF_CHARACTERS * BITS_OF_A_CHARACTER * US_PER_S / 2U / (uint64_t)settings->baud;
    *serial = (gateway_serial_t){.stream = {.fd = -1}, .gap_us = (gap_us > LEAST_GAP_US) ? gap_us : LEAST_GAP_US};
    serial->line = modbus_new_rtu(settings->device, settings->baud, settings->parity, 8, 1);
    if (serial->line == NULL) {
        return false;
    }
    if (!connect_line(serial)) {
        const int reason = errno;
        modbus_free(serial->line);
        serial->line = NULL;
        errno = reason;
        return false;
    }
    return true;
}

static void lose_line(gateway_serial_t *serial, gateway_t *gateway, uint64_t now_us)
{
    tumble_count(&gateway->counters[GATEWAY_COUNT_SERIAL_FAULTS]);
    gateway_session_close(&serial->stream.session, gateway);
    modbus_close(serial->line);
    serial->stream.fd = -1;
    serial->reopen_us = now_us + REOPEN_US;
}

/* A master that asks anew while its last answer is still going out no longer waits for that. */
static void answer(gateway_serial_t *serial, gateway_t *gateway, size_t size, uint64_t now_us)
{
    serial->stream.out_count =
        gateway_answer(gateway, &serial->stream.session, true, serial->stream.in, size, now_us, serial->stream.out);
    gateway_stream_drop(&serial->stream, size);
}

static bool is_gap(const gateway_serial_t *serial, uint64_t now_us)
{
    return serial->stream.in_count > 0U && now_us >= serial->heard_us + serial->gap_us;
}

static void take_frames(gateway_serial_t *serial, gateway_t *gateway, uint64_t now_us)
{
    size_t size;
    while ((size = gateway_serial_frame(serial->stream.in, serial->stream.in_count, gateway->settings.unit)) > 0U) {
        answer(serial, gateway, size, now_us);
    }
    if (!is_gap(serial, now_us) && serial->stream.in_count < sizeof serial->stream.in) {
        return;
    }
    if (serial->stream.in_count >= LEAST_FRAME && serial->stream.in_count <= GATEWAY_MAX_SERIAL &&
        gateway_serial_is_whole(serial->stream.in, serial->stream.in_count)) {
        answer(serial, gateway, serial->stream.in_count, now_us);
    } else {
        tumble_count(&gateway->counters[GATEWAY_COUNT_SERIAL_CRC]);
        gateway_stream_drop(&serial->stream, serial->stream.in_count);
    }
}

void gateway_serial_step(gateway_serial_t *serial, gateway_t *gateway, bool hung_up, uint64_t now_us)
{
    if (serial->stream.fd < 0 && (now_us < serial->reopen_us || !connect_line(serial))) {
        serial->reopen_us = (now_us < serial->reopen_us) ? serial->reopen_us : now_us + REOPEN_US;
        return;
    }
    const size_t before = serial->stream.in_count;
    const bool is_up = gateway_stream_send(&serial->stream) && gateway_stream_receive(&serial->stream) >= 0;
    serial->heard_us = (serial->stream.in_count > before) ? now_us : serial->heard_us;
    take_frames(serial, gateway, now_us);
    if (hung_up || !is_up || !gateway_stream_send(&serial->stream)) {
        lose_line(serial, gateway, now_us);
    }
}

uint32_t gateway_serial_events(const gateway_serial_t *serial)
{
    return (uint32_t)EPOLLIN | ((serial->stream.out_count > 0U) ? (uint32_t)EPOLLOUT : 0U);
}

uint64_t gateway_serial_next_us(const gateway_serial_t *serial)
{
    if (serial->stream.fd < 0) {
        return serial->reopen_us;
    }
    return (serial->stream.in_count > 0U) ? serial->heard_us + serial->gap_us : TUMBLE_NEVER;
}

void gateway_serial_close(gateway_serial_t *serial, gateway_t *gateway)
{
    gateway_session_close(&serial->stream.session, gateway);
    modbus_close(serial->line);
    modbus_free(serial->line);
    serial->stream.fd = -1;
}
