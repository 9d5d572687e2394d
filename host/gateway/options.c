#include "server.h"

#include "event_log.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>

static const char HELP[] =
    "usage: tumble-gateway --can INTERFACE [options]\n"
    "\n"
    "Serves what the navigation computer on a CAN interface of Linux knows as\n"
    "Modbus registers: over TCP, on a serial line, or both. Read only, and on this\n"
    "machine alone, unless told otherwise. The registers stand in docs/modbus.md.\n"
    "Runs until SIGTERM or SIGINT; no root needed.\n"
    "\n"
    "  --can INTERFACE           such as can0 or vcan0\n"
    "  --tcp HOST:PORT           where to listen (default 127.0.0.1:1502;\n"
    "                            [::1]:1502; port 0: any); none: not\n"
    "  --rtu DEVICE,BAUD,PARITY  a serial line as well, such as\n"
    "                            /dev/ttyUSB0,19200,E (parity N, E or O)\n"
    "  --unit N                  Modbus unit that is answered (default 1)\n"
    "  --node N                  CANopen node that is asked (default 1)\n"
    "  --poll MS                 time from one reading of the node to the next\n"
    "                            (default 1000)\n"
    "  --idle S                  close a TCP client after such a silence\n"
    "                            (default 60)\n"
    "  --allow-commands          a session may command the node once it is unlocked\n"
    "  --unlock S                it locks itself so long after its last write\n"
    "                            (default 60)\n"
    "  --log FORM                tell every event on standard error, a line for\n"
    "                            each: text or json (docs/operations.md)\n"
    "  --log-level LEVEL         error, warning, notice or info: this and what is\n"
    "                            worse (default info)\n"
    "  --version                 print the version\n"
    "  -h, --help                print this\n"
    "\n"
    "Exit codes: 0 told to end; 2 bad usage, or no such interface; 3 it cannot\n"
    "listen, or the line cannot be opened; 77 this kernel has no CAN.\n";

#define DEFAULT_TCP "127.0.0.1:1502"
#define US_PER_MS 1000U
#define US_PER_S 1000000U

/* HOST:PORT; a host in brackets may have colons. */
static bool take_tcp(void *to, const char *text)
{
    gateway_options_t *const options = to;
    uint64_t port = 0;
    options->has_tcp = strcmp(text, "none") != 0;
    if (!options->has_tcp) {
        return true;
    }
    const bool fits = strlen(text) < sizeof options->tcp;
    (void)snprintf(options->tcp, sizeof options->tcp, "%s", text);
    if (!fits || !arguments_cut_address(options->tcp, &options->host, &options->port)) {
        return arguments_refuse("--tcp", "must be HOST:PORT, [ADDRESS]:PORT or none");
    }
    return arguments_whole("--tcp: port", options->port, 0, 65535, &port);
}

/* DEVICE,BAUD,PARITY */
static bool take_rtu(void *to, const char *text)
{
    gateway_options_t *const options = to;
    char baud_text[12];
    uint64_t baud = 0;
    const char *const first = strchr(text, ',');
    const char *const second = (first != NULL) ? strchr(first + 1, ',') : NULL;
    const size_t size = (first != NULL) ? (size_t)(first - text) : 0U;
    if (second == NULL || size == 0U || size >= sizeof options->serial.device || strchr("NEO", second[1]) == NULL ||
        second[1] == '\0' || second[2] != '\0' || (size_t)(second - first) > sizeof baud_text) {
        return arguments_refuse("--rtu", "must be DEVICE,BAUD,PARITY with parity N, E or O");
    }
    (void)snprintf(baud_text, sizeof baud_text, "%.*s", (int)(second - first - 1), first + 1);
    if (!arguments_whole("--rtu: baud", baud_text, 1200, 921600, &baud)) {
        return false;
    }
    memcpy(options->serial.device, text, size);
    options->serial.device[size] = '\0';
    options->serial.baud = (int)baud;
    options->serial.parity = second[1];
    options->has_serial = true;
    return true;
}

static const argument_t OPTIONS[] = {
    ARGUMENT_ANY_TEXT("can", gateway_options_t, can),
    ARGUMENT_TAKE("tcp", take_tcp),
    ARGUMENT_TAKE("rtu", take_rtu),
    ARGUMENT_WHOLE("unit", gateway_options_t, settings.unit, 1, 247),
    ARGUMENT_WHOLE("node", gateway_options_t, settings.node, 1, 127),
    ARGUMENT_UNITS("poll", gateway_options_t, settings.poll_us, 50, 3600000, US_PER_MS),
    ARGUMENT_UNITS("idle", gateway_options_t, settings.idle_us, 1, 86400, US_PER_S),
    ARGUMENT_FLAG("allow-commands", gateway_options_t, settings.allow_commands),
    ARGUMENT_UNITS("unlock", gateway_options_t, settings.unlock_us, 1, 3600, US_PER_S),
    EVENT_LOG_ARGUMENTS,
};

static const arguments_program_t PROGRAM = {"tumble-gateway", HELP, OPTIONS, sizeof OPTIONS / sizeof OPTIONS[0]};

/* What no single option can show. */
static bool fit(const gateway_options_t *options, const char *operand)
{
    if (operand != NULL) {
        return arguments_refuse(operand, "is no option; see --help");
    }
    if (options->can == NULL || *options->can == '\0') {
        return arguments_refuse("--can", "is missing: the CAN interface");
    }
    return options->has_tcp || options->has_serial ||
           arguments_refuse("--tcp none", "needs --rtu, or there is nothing to serve");
}

int gateway_options_read(gateway_options_t *options, int count, char *arguments[])
{
    *options = (gateway_options_t){.settings = {.unit = 1,
                                                .node = 1,
                                                .unlock_us = 60U * US_PER_S,
                                                .idle_us = 60U * US_PER_S,
                                                .poll_us = 1000U * US_PER_MS}};
    (void)take_tcp(options, DEFAULT_TCP);
    const int code = arguments_read(count, arguments, &PROGRAM, options);
    return (code == ARGUMENTS_WORK && !fit(options, arguments[optind])) ? BENCH_EXIT_USAGE : code;
}
