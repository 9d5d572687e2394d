#define _POSIX_C_SOURCE 200809L

#include "serial.h"

#include <errno.h>
#include <string.h>
#include <sys/epoll.h>
#include <unistd.h>

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
    serial->fd = modbus_get_socket(serial->line);
    serial->in_count = 0;
    serial->out_count = 0;
    return true;
}

bool gateway_serial_open(gateway_serial_t *serial, const gateway_serial_settings_t *settings)
{
    const uint64_t gap_us =
        (uint64_t)GAP_HALF_CHARACTERS * BITS_OF_A_CHARACTER * US_PER_S / 2U / (uint64_t)settings->baud;
    *serial = (gateway_serial_t){.fd = -1, .gap_us = (gap_us > LEAST_GAP_US) ? gap_us : LEAST_GAP_US};
    gateway_session_open(&serial->session);
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
    gateway_count(&gateway->counters, GATEWAY_COUNT_SERIAL_FAULTS);
    gateway_session_close(&serial->session, gateway);
    modbus_close(serial->line);
    serial->fd = -1;
    serial->reopen_us = now_us + REOPEN_US;
}

static bool is_passing(ssize_t done)
{
    return done < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR);
}

static bool send_out(gateway_serial_t *serial)
{
    if (serial->out_count == 0U) {
        return true;
    }
    const ssize_t sent = write(serial->fd, serial->out, serial->out_count);
    if (sent <= 0) {
        return is_passing(sent);
    }
    serial->out_count -= (size_t)sent;
    memmove(serial->out, &serial->out[sent], serial->out_count);
    return true;
}

/* As libmodbus sets the line up, it reads as 0 bytes when nothing has come. */
static bool receive(gateway_serial_t *serial, uint64_t now_us)
{
    const size_t room = sizeof serial->in - serial->in_count;
    const ssize_t got = (room > 0U) ? read(serial->fd, &serial->in[serial->in_count], room) : 0;
    if (got > 0) {
        serial->heard_us = now_us;
        serial->in_count += (size_t)got;
    }
    return got >= 0 || is_passing(got);
}

static void drop(gateway_serial_t *serial, size_t size)
{
    serial->in_count -= size;
    memmove(serial->in, &serial->in[size], serial->in_count);
}

/* A master that asks anew while its last answer is still going out no longer waits for that. */
static void answer(gateway_serial_t *serial, gateway_t *gateway, const gateway_replies_t *replies, size_t size,
                   uint64_t now_us)
{
    serial->out_count = gateway_answer(gateway, replies, &serial->session, true, serial->in, size, now_us, serial->out);
    drop(serial, size);
}

static bool is_gap(const gateway_serial_t *serial, uint64_t now_us)
{
    return serial->in_count > 0U && now_us >= serial->heard_us + serial->gap_us;
}

static void take_frames(gateway_serial_t *serial, gateway_t *gateway, const gateway_replies_t *replies, uint64_t now_us)
{
    size_t size;
    while ((size = gateway_serial_frame(serial->in, serial->in_count, gateway->settings.unit)) > 0U) {
        answer(serial, gateway, replies, size, now_us);
    }
    if (!is_gap(serial, now_us) && serial->in_count < sizeof serial->in) {
        return;
    }
    if (serial->in_count >= LEAST_FRAME && serial->in_count <= GATEWAY_MAX_SERIAL &&
        gateway_serial_is_whole(serial->in, serial->in_count)) {
        answer(serial, gateway, replies, serial->in_count, now_us);
    } else {
        gateway_count(&gateway->counters, GATEWAY_COUNT_SERIAL_CRC);
        drop(serial, serial->in_count);
    }
}

void gateway_serial_step(gateway_serial_t *serial, gateway_t *gateway, const gateway_replies_t *replies, bool hung_up,
                         uint64_t now_us)
{
    if (serial->fd < 0 && (now_us < serial->reopen_us || !connect_line(serial))) {
        serial->reopen_us = (now_us < serial->reopen_us) ? serial->reopen_us : now_us + REOPEN_US;
        return;
    }
    const bool is_up = send_out(serial) && receive(serial, now_us);
    take_frames(serial, gateway, replies, now_us);
    if (hung_up || !is_up || !send_out(serial)) {
        lose_line(serial, gateway, now_us);
    }
}

uint32_t gateway_serial_events(const gateway_serial_t *serial)
{
    return (uint32_t)EPOLLIN | ((serial->out_count > 0U) ? (uint32_t)EPOLLOUT : 0U);
}

uint64_t gateway_serial_next_us(const gateway_serial_t *serial)
{
    if (serial->fd < 0) {
        return serial->reopen_us;
    }
    return (serial->in_count > 0U) ? serial->heard_us + serial->gap_us : TUMBLE_NEVER;
}

void gateway_serial_close(gateway_serial_t *serial, gateway_t *gateway)
{
    gateway_session_close(&serial->session, gateway);
    modbus_close(serial->line);
    modbus_free(serial->line);
    serial->fd = -1;
}
