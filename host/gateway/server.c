#define _GNU_SOURCE

#include "server.h"

#include "client.h"
#include "event_log.h"
#include "events.h"
#include "gateway_log.h"

#include <errno.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#define US_PER_MS 1000U
#define MAX_READY 16
#define LONGEST_WAIT_MS 60000U
#define NAME_BYTES 192
#define MAX_ACCEPTED 8 /* at one time */

/* Clients that cannot be accepted leave the listener readable: it rests, or the loop would turn without end. */
#define REST_US 500000U
#define WELL_US 60000000U /* it is told again after such a time without */

/* What is ready, as epoll's data; clients from CLIENTS on. (poll would refuse to wait for more descriptors than the process
 * may have, and that is when the loop must rest.) */
enum { SIGNALS = 0, LISTENER, BUS, SERIAL, CLIENTS };

typedef struct {
    gateway_t gateway;
    const tumble_port_t *port;
    int epoll;
    int signals;
    int listener; /* -1: none */
    bool rests;   /* the listener is not watched until `rests_until_us`, or until a client has gone */
    uint64_t rests_until_us;
    uint64_t told_until_us; /* why it rests is known to whoever reads standard error */
    bool has_serial;
    bool has_ended;
    bool line_hung_up;
    gateway_serial_t serial;
    gateway_client_t clients[GATEWAY_MAX_CLIENTS];
    gateway_log_t log;
} server_t;

static uint64_t clock_us(const server_t *server)
{
    return server->port->now_us(server->port->context);
}

static bool watch(const server_t *server, int operation, int fd, uint32_t tag, uint32_t events)
{
    struct epoll_event event = {.events = events, .data = {.u32 = tag}};
    return epoll_ctl(server->epoll, operation, fd, &event) == 0;
}

/* Wait for these of a client or of the serial line. */
static bool watch_stream(const server_t *server, gateway_stream_t *stream, uint32_t tag, uint32_t events)
{
    const int operation = (stream->watched == 0U) ? EPOLL_CTL_ADD : EPOLL_CTL_MOD;
    const bool is_done = stream->watched == events || watch(server, operation, stream->fd, tag, events);
    stream->watched = events;
    return is_done;
}

/* Clients. */

/* What has happened to a session, to the log. */
static void note_client(server_t *server, uint32_t place)
{
    gateway_client_t *const client = &server->clients[place];
    gateway_log_session(&client->stream, client->address.text, clock_us(server));
}

static void close_client(server_t *server, uint32_t place, const char *why)
{
    note_client(server, place);
    gateway_client_close(&server->clients[place], &server->gateway);
    server->gateway.clients--;
    gateway_log_disconnected(&server->clients[place].address, why, server->gateway.clients);
    server->rests_until_us = 0;
}

static void step_client(server_t *server, uint32_t place)
{
    gateway_client_t *const client = &server->clients[place];
    if (client->stream.fd < 0) {
        return;
    }
    if (!gateway_client_step(client, &server->gateway, clock_us(server))) {
        close_client(server, place, client->has_ended ? "by itself" : "broken off, or it speaks no Modbus");
        return;
    }
    note_client(server, place);
    (void)watch_stream(server, &client->stream, CLIENTS + place, gateway_client_events(client));
}

/* When all places are taken, hear everybody first: a request or an end may have come that no event has told of yet. */
static uint32_t make_place(server_t *server, const gateway_address_t *address)
{
    for (uint32_t place = 0; server->gateway.clients == GATEWAY_MAX_CLIENTS && place < GATEWAY_MAX_CLIENTS; place++) {
        step_client(server, place);
    }
    const uint32_t place = gateway_place_for(server->clients, address, clock_us(server));
    if (place < GATEWAY_MAX_CLIENTS && server->clients[place].stream.fd >= 0) {
        tumble_count(&server->gateway.counters[GATEWAY_COUNT_CONNECTIONS_DISPLACED]);
        close_client(server, place, "its place was wanted");
    }
    return place;
}

static void admit(server_t *server, int fd, const gateway_address_t *address)
{
    const uint32_t place = make_place(server, address);
    if (place == GATEWAY_MAX_CLIENTS || !watch(server, EPOLL_CTL_ADD, fd, CLIENTS + place, EPOLLIN)) {
        tumble_count(&server->gateway.counters[GATEWAY_COUNT_CONNECTIONS_REFUSED]);
        gateway_log_turned_away(address);
        (void)close(fd);
        return;
    }
    tumble_count(&server->gateway.counters[GATEWAY_COUNT_CONNECTIONS]);
    gateway_client_open(&server->clients[place], fd, address, clock_us(server));
    server->clients[place].stream.watched = EPOLLIN;
    server->gateway.clients++;
    gateway_log_connected(address, server->gateway.clients);
}

static void watch_listener(server_t *server, bool rests)
{
    server->rests = rests;
    (void)watch(server, EPOLL_CTL_MOD, server->listener, LISTENER, rests ? 0U : (uint32_t)EPOLLIN);
}

static void rest(server_t *server, const char *what)
{
    const uint64_t now_us = clock_us(server);
    tumble_count(&server->gateway.counters[GATEWAY_COUNT_CONNECTIONS_PUT_OFF]);
    if (now_us >= server->told_until_us) {
        event_log_always(EVENT_LOG_WARNING, "put_off", EVENT_FIELDS(EVENT_TEXT("why", what)),
                         "cannot accept connections: %s; trying again", what);
    }
    server->told_until_us = now_us + WELL_US;
    server->rests_until_us = now_us + REST_US;
    watch_listener(server, true);
}

static void admit_all(server_t *server)
{
    int fd;
    bool is_short = false;
    gateway_address_t address;
    for (int i = 0; i < MAX_ACCEPTED && (fd = gateway_accept(server->listener, &address, &is_short)) >= 0; i++) {
        admit(server, fd, &address);
    }
    if (is_short) {
        rest(server, strerror(errno));
    }
}

static void end_rest(server_t *server)
{
    if (server->rests && clock_us(server) >= server->rests_until_us) {
        watch_listener(server, false);
    }
}

static void close_idle(server_t *server)
{
    const uint64_t now_us = clock_us(server);
    for (uint32_t place = 0; place < GATEWAY_MAX_CLIENTS; place++) {
        const gateway_client_t *const client = &server->clients[place];
        if (client->stream.fd >= 0 && now_us >= gateway_client_deadline_us(client, &server->gateway.settings)) {
            tumble_count(&server->gateway.counters[GATEWAY_COUNT_CONNECTIONS_IDLE]);
            close_client(server, place, "silent for too long");
        }
    }
}

/* The serial line. */

static void step_serial(server_t *server)
{
    if (!server->has_serial) {
        return;
    }
    gateway_serial_step(&server->serial, &server->gateway, server->line_hung_up, clock_us(server));
    server->line_hung_up = false;
    gateway_log_session(&server->serial.stream, "the serial line", clock_us(server));
    if (server->serial.stream.fd >= 0) {
        (void)watch_stream(server, &server->serial.stream, SERIAL, gateway_serial_events(&server->serial));
    }
}

/* The loop. */

static void take(server_t *server, const struct epoll_event *ready)
{
    switch (ready->data.u32) {
    case SIGNALS:
        server->has_ended = true;
        break;
    case LISTENER:
        admit_all(server);
        break;
    case BUS: /* the poller is stepped in any case */
        break;
    case SERIAL:
        server->line_hung_up = (ready->events & (EPOLLHUP | EPOLLERR)) != 0U;
        break;
    default:
        step_client(server, ready->data.u32 - CLIENTS);
        break;
    }
}

static uint64_t next_us(const server_t *server)
{
    uint64_t next = gateway_poller_next_us(&server->gateway.poller);
    const uint64_t line_us = server->has_serial ? gateway_serial_next_us(&server->serial) : TUMBLE_NEVER;
    next = (line_us < next) ? line_us : next;
    next = (server->rests && server->rests_until_us < next) ? server->rests_until_us : next;
    for (uint32_t place = 0; place < GATEWAY_MAX_CLIENTS; place++) {
        if (server->clients[place].stream.fd >= 0) {
            const uint64_t at = gateway_client_deadline_us(&server->clients[place], &server->gateway.settings);
            next = (at < next) ? at : next;
        }
    }
    return next;
}

static int wait_ms(const server_t *server)
{
    const uint64_t now_us = clock_us(server);
    const uint64_t at_us = next_us(server);
    const uint64_t ms = (at_us > now_us) ? (at_us - now_us - 1U) / US_PER_MS + 1U : 0U;
    return (int)((ms < LONGEST_WAIT_MS) ? ms : LONGEST_WAIT_MS);
}

/* The node may have answered, or be another than it was. */
static void note_results(server_t *server)
{
    gateway_log_node(&server->log, &server->gateway.poller);
    for (uint32_t place = 0; event_log_is_on() && place < GATEWAY_MAX_CLIENTS; place++) {
        if (server->clients[place].stream.fd >= 0) {
            note_client(server, place);
        }
    }
}

static void serve(server_t *server)
{
    struct epoll_event ready[MAX_READY];
    while (!server->has_ended) {
        gateway_poller_step(&server->gateway.poller);
        note_results(server);
        step_serial(server);
        close_idle(server);
        end_rest(server);
        const int count = epoll_wait(server->epoll, ready, MAX_READY, wait_ms(server));
        for (int i = 0; i < count; i++) {
            take(server, &ready[i]);
        }
    }
}

/* Getting ready. */

static bool open_events(server_t *server, int can_fd)
{
    server->epoll = epoll_create1(EPOLL_CLOEXEC);
    server->signals = signals_open(0);
    return server->epoll >= 0 && watch(server, EPOLL_CTL_ADD, server->signals, SIGNALS, EPOLLIN) &&
           watch(server, EPOLL_CTL_ADD, can_fd, BUS, EPOLLIN);
}

static int open_tcp(server_t *server, const gateway_options_t *options)
{
    const char *what = "";
    server->listener = gateway_listen(options->host, options->port, &what);
    if (server->listener < 0 || !watch(server, EPOLL_CTL_ADD, server->listener, LISTENER, EPOLLIN)) {
        return arguments_fail(options->host, what, BENCH_EXIT_FAULT);
    }
    return BENCH_EXIT_PASS;
}

static int open_all(server_t *server, const gateway_options_t *options, int can_fd)
{
    if (!open_events(server, can_fd)) {
        return arguments_fail("waiting for events", strerror(errno), BENCH_EXIT_FAULT);
    }
    if (options->has_serial && !gateway_serial_open(&server->serial, &options->serial)) {
        return arguments_fail(options->serial.device, modbus_strerror(errno), BENCH_EXIT_FAULT);
    }
    server->has_serial = options->has_serial;
    return options->has_tcp ? open_tcp(server, options) : BENCH_EXIT_PASS;
}

/* Send a state such as "READY=1" to the manager of services (systemd, Type=notify), where NOTIFY_SOCKET names one. */
static void notify_manager(const char *state)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const char *const path = getenv("NOTIFY_SOCKET");
    if (path == NULL || (*path != '/' && *path != '@') || strlen(path) >= sizeof address.sun_path) {
        return;
    }
    memcpy(address.sun_path, path, strlen(path));
    if (*path == '@') { /* a name without a file */
        address.sun_path[0] = '\0';
    }
    const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (fd >= 0) {
        const socklen_t size = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + strlen(path));
        (void)!sendto(fd, state, strlen(state), MSG_NOSIGNAL, (const struct sockaddr *)&address, size);
        (void)close(fd);
    }
}

/* One line, for a person, a journal, and whoever asked for any free port. */
static void announce(const server_t *server, const gateway_options_t *options)
{
    char name[NAME_BYTES] = "";
    if (server->listener >= 0) {
        gateway_listener_name(server->listener, name, sizeof name);
    }
    const char *const between = (server->listener >= 0 && server->has_serial) ? " and " : "";
    const char *const device = server->has_serial ? options->serial.device : "";
    const char *const access = options->settings.allow_commands ? "commands allowed" : "read only";
    event_log_start("tumble-gateway", STDERR_FILENO);
    event_log_always(EVENT_LOG_NOTICE, "ready",
                     EVENT_FIELDS(EVENT_WHOLE("node", options->settings.node), EVENT_TEXT("interface", options->can),
                                  EVENT_WHOLE("unit", options->settings.unit), EVENT_TEXT("tcp", name),
                                  EVENT_TEXT("rtu", device), EVENT_TEXT("access", access)),
                     "node %u on %s, unit %u at %s%s%s, %s", options->settings.node, options->can,
                     options->settings.unit, name, between, device, access);
    notify_manager("READY=1");
}

static void close_all(server_t *server)
{
    for (uint32_t place = 0; place < GATEWAY_MAX_CLIENTS; place++) {
        if (server->clients[place].stream.fd >= 0) {
            close_client(server, place, "the gateway ends");
        }
    }
    if (server->has_serial) {
        gateway_serial_close(&server->serial, &server->gateway);
    }
    if (server->listener >= 0) {
        (void)close(server->listener);
    }
    (void)close(server->signals);
    (void)close(server->epoll);
}

int gateway_serve(const gateway_options_t *options, const tumble_port_t *port, int can_fd)
{
    static server_t server;
    server = (server_t){.port = port, .listener = -1, .gateway = {.settings = options->settings}};
    for (uint32_t place = 0; place < GATEWAY_MAX_CLIENTS; place++) {
        server.clients[place].stream.fd = -1;
    }
    gateway_poller_init(&server.gateway.poller, port, options->settings.node, options->settings.poll_us,
                        server.gateway.counters);
    const int code = open_all(&server, options, can_fd);
    if (code == BENCH_EXIT_PASS) {
        announce(&server, options);
        serve(&server);
        notify_manager("STOPPING=1");
    }
    close_all(&server);
    event_log_end(EVENT_LOG_NOTICE, EVENT_FIELDS(EVENT_WHOLE("exit", (uint64_t)code)), "ends with exit code %d", code);
    gateway_poller_step(
        &server.gateway.poller); /* the end of a service level, unless the bus is busy: else it ends itself */
    return code;
}
