#define _POSIX_C_SOURCE 200809L

#include "bench/guests.h"

#include "bench/interrupt.h"
#include "core/bytes.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#define TURN_COMMAND 0x80000000U
#define DEG_PER_UNIT 1e-5
#define LONG_WAIT_S 1.0
#define PATIENCE_MS 10000 /* with a guest that is behind when the run ends */

static void send_away(bench_guests_t *guests, bench_guest_t *guest)
{
    (void)close(guest->socket);
    guest->socket = -1;
    guest->have = 0;
    guest->waiting = 0;
    guests->present--;
}

/* As much of the backlog as its socket takes. False: it is gone. */
static bool send_backlog(bench_guest_t *guest)
{
    while (guest->waiting > 0U) {
        const uint32_t to_end = (uint32_t)sizeof guest->backlog - guest->first;
        const uint32_t span = (guest->waiting < to_end) ? guest->waiting : to_end;
        const ssize_t sent = send(guest->socket, guest->backlog + guest->first, span, MSG_NOSIGNAL);
        if (sent < 0) {
            return errno == EAGAIN || errno == EINTR;
        }
        guest->first = (guest->first + (uint32_t)sent) % (uint32_t)sizeof guest->backlog;
        guest->waiting -= (uint32_t)sent;
    }
    return true;
}

/* False: it is gone, or so slow that its backlog is full. */
static bool tell(bench_guest_t *guest, const uint8_t *record)
{
    if (guest->waiting > sizeof guest->backlog - BENCH_GUEST_RECORD) {
        return false;
    }
    for (uint32_t i = 0; i < BENCH_GUEST_RECORD; i++) { /* the ring may end within a record of which a part was sent */
        guest->backlog[(guest->first + guest->waiting + i) % sizeof guest->backlog] = record[i];
    }
    guest->waiting += BENCH_GUEST_RECORD;
    return send_backlog(guest);
}

static const char *listen_at(bench_guests_t *guests, const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path) {
        return "is too long for the path of a socket";
    }
    (void)memcpy(address.sun_path, path, strlen(path));
    guests->listener = socket(AF_UNIX, SOCK_STREAM, 0);
    if (guests->listener < 0 || bind(guests->listener, (const struct sockaddr *)&address, sizeof address) != 0 ||
        listen(guests->listener, BENCH_MAX_GUESTS) != 0) {
        const char *const wrong = strerror(errno);
        if (guests->listener >= 0) {
            (void)close(guests->listener);
        }
        return wrong;
    }
    return NULL;
}

const char *bench_guests_open(bench_guests_t *guests, const char *path, uint32_t awaited)
{
    memset(guests, 0, sizeof *guests);
    guests->path = path;
    for (uint32_t i = 0; i < BENCH_MAX_GUESTS; i++) {
        guests->guests[i].socket = -1;
    }
    const char *const wrong = listen_at(guests, path);
    if (wrong != NULL) {
        return wrong;
    }
    while (guests->present < awaited && !bench_interrupted()) {
        (void)bench_guests_poll(guests, LONG_WAIT_S);
    }
    return NULL;
}

static void welcome(bench_guests_t *guests)
{
    const int newcomer = accept(guests->listener, NULL, NULL);
    if (newcomer < 0) {
        return;
    }
    for (uint32_t i = 0; i < BENCH_MAX_GUESTS; i++) {
        if (guests->guests[i].socket < 0) {
            (void)fcntl(newcomer, F_SETFL, O_NONBLOCK);
            guests->guests[i].socket = newcomer;
            guests->present++;
            guests->had_any = true;
            return;
        }
    }
    (void)close(newcomer); /* the table is full */
}

bool bench_guests_poll(bench_guests_t *guests, double timeout_s)
{
    struct pollfd watched[1 + BENCH_MAX_GUESTS];
    watched[0] = (struct pollfd){.fd = guests->listener, .events = POLLIN};
    for (uint32_t i = 0; i < BENCH_MAX_GUESTS; i++) {
        const bench_guest_t *const guest = &guests->guests[i]; /* the socket -1 is passed over */
        watched[1U + i] = (struct pollfd){guest->socket, (short)(POLLIN | ((guest->waiting > 0U) ? POLLOUT : 0)), 0};
    }
    const int ready = poll(watched, 1 + BENCH_MAX_GUESTS, (int)(timeout_s * 1e3));
    if (ready > 0 && watched[0].revents != 0) {
        welcome(guests);
    }
    for (uint32_t i = 0; i < BENCH_MAX_GUESTS; i++) {
        if (ready > 0 && (watched[1U + i].revents & POLLOUT) != 0 && !send_backlog(&guests->guests[i])) {
            send_away(guests, &guests->guests[i]);
        }
    }
    return ready > 0;
}

static void turn_table(bench_world_t *world, const uint8_t *data)
{
    const double angle_deg = DEG_PER_UNIT * (double)tumble_get_i32(data);
    const double speed_deg_s = DEG_PER_UNIT * (double)tumble_get_u32(data + 4);
    if (speed_deg_s > 0.0 && !world->config->present.drive) {
        bench_world_turn(world, angle_deg, speed_deg_s);
    }
}

bool bench_guests_read(bench_world_t *world, uint8_t node, const uint8_t *record)
{
    const uint32_t id = tumble_get_u32(record);
    if (id == TURN_COMMAND) {
        turn_table(world, record + 8);
        return true;
    }
    tumble_can_frame_t frame = {.id = (uint16_t)(id & TUMBLE_CAN_MAX_ID), .length = record[4]};
    if (id > TUMBLE_CAN_MAX_ID || frame.length > TUMBLE_CAN_MAX_BYTES) {
        return false;
    }
    (void)memcpy(frame.data, record + 8, TUMBLE_CAN_MAX_BYTES);
    (void)sim_bus_send(&world->bus, node, &frame); /* the bus counts those that find the queue full */
    return true;
}

static void take_from(bench_guests_t *guests, bench_world_t *world, uint32_t number)
{
    bench_guest_t *const guest = &guests->guests[number];
    while (guest->socket >= 0) {
        const ssize_t got = recv(guest->socket, guest->bytes + guest->have, BENCH_GUEST_RECORD - guest->have, 0);
        if (got < 0 && (errno == EAGAIN || errno == EINTR)) {
            return;
        }
        if (got <= 0) {
            send_away(guests, guest);
            return;
        }
        guest->have += (uint32_t)got;
        if (guest->have == BENCH_GUEST_RECORD) {
            guest->have = 0;
            if (!bench_guests_read(world, (uint8_t)(BENCH_BUS_GUEST + number), guest->bytes)) {
                send_away(guests, guest);
            }
        }
    }
}

void bench_guests_take(bench_guests_t *guests, bench_world_t *world)
{
    for (uint32_t i = 0; i < BENCH_MAX_GUESTS; i++) {
        take_from(guests, world, i);
    }
}

void bench_guests_write(uint8_t *record, const tumble_can_frame_t *frame)
{
    (void)memset(record, 0, BENCH_GUEST_RECORD);
    tumble_put_u32(record, frame->id);
    record[4] = frame->length;
    (void)memcpy(record + 8, frame->data, frame->length);
}

void bench_guests_tell(bench_guests_t *guests, uint8_t sender, const tumble_can_frame_t *frame)
{
    uint8_t record[BENCH_GUEST_RECORD];
    bench_guests_write(record, frame);
    for (uint32_t i = 0; i < BENCH_MAX_GUESTS; i++) {
        bench_guest_t *const guest = &guests->guests[i];
        if (guest->socket >= 0 && sender != BENCH_BUS_GUEST + i && !tell(guest, record)) {
            send_away(guests, guest);
        }
    }
}

bool bench_guests_have_left(const bench_guests_t *guests)
{
    return guests->had_any && guests->present == 0U;
}

void bench_guests_close(bench_guests_t *guests)
{
    for (uint32_t i = 0; i < BENCH_MAX_GUESTS; i++) {
        bench_guest_t *const guest = &guests->guests[i];
        struct pollfd room = {guest->socket, POLLOUT, 0};
        while (guest->waiting > 0U && !bench_interrupted() && poll(&room, 1, PATIENCE_MS) > 0 && send_backlog(guest)) {
        }
        if (guest->socket >= 0) {
            send_away(guests, guest);
        }
    }
    (void)close(guests->listener);
    (void)unlink(guests->path);
}
