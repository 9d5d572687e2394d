#define _DEFAULT_SOURCE /* strsep */

#include "positioner_option.h"

#include "arguments.h"
#include "modbus_link.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define OPTION "--stand"
#define FORM "must be modbus:HOST:PORT[,NAME=NUMBER...], with PORT from 1 to 65535; see --help"
#define SCHEME "modbus:"
#define PARTS_OF_SILENCE 3U /* a connection and two questions, within the time after which the link is dead */

static char text[256];
static const char *host; /* null: the option was not given */
static const char *port;
static uint8_t unit = 1;
static unsigned given; /* a bit for each of NUMBERS */
static tumble_positioner_profile_t profile = {
    .counts_per_deg = 10000.0,
    .window_deg = 0.02,
    .home_timeout_ms = 120000,
    .move_timeout_ms = 60000,
    .stop_timeout_ms = 2000,
    .cycle_ms = 20,
    .silence_ms = 500,
    .watch_ms = 500,
    .speed_deg_s = 0.0,
};

typedef struct {
    const char *name;
    void *at;
    size_t size; /* 8: a double */
    double low;
    double high;
} number_t;

#define NUMBER(member, low, high) {#member, &profile.member, sizeof profile.member, (low), (high)}

static const number_t NUMBERS[] = {
    {"unit", &unit, sizeof unit, 0, 247}, NUMBER(counts_per_deg, -1e6, 1e6), NUMBER(window_deg, 1e-6, 10),
    NUMBER(home_timeout_ms, 1, 1e9),      NUMBER(move_timeout_ms, 1, 1e9),   NUMBER(stop_timeout_ms, 1, 60000),
    NUMBER(cycle_ms, 1, 10000),           NUMBER(silence_ms, 2, 60000),      NUMBER(watch_ms, 2, 60000),
    NUMBER(speed_deg_s, 0, 1e4),
};

static bool is_port(const char *digits)
{
    const size_t length = strspn(digits, "0123456789");
    const unsigned long number = strtoul(digits, NULL, 10);
    return length > 0U && length <= 5U && digits[length] == '\0' && number > 0U && number <= UINT16_MAX;
}

static bool put(const number_t *number, double value)
{
    const uint32_t whole = (value > 0.0) ? (uint32_t)value : 0U;
    if (number->size == sizeof(double)) {
        *(double *)number->at = value;
        return true;
    }
    arguments_store(whole, number->size, number->at);
    return (double)whole == value;
}

static bool take_number(const char *name, const char *digits)
{
    for (size_t i = 0; i < sizeof NUMBERS / sizeof NUMBERS[0]; i++) {
        const number_t *const number = &NUMBERS[i];
        if (strcmp(name, number->name) == 0) {
            if ((given & (1U << i)) != 0U) {
                return arguments_refuse(OPTION, "has a number twice");
            }
            given |= 1U << i;
            char *end = NULL;
            const double value = strtod(digits, &end);
            return (end != digits && *end == '\0' && value >= number->low && value <= number->high &&
                    put(number, value)) ||
                   arguments_refuse(OPTION, "a number is out of its range, or no number; see --help");
        }
    }
    return arguments_refuse(OPTION, "no such number of a stand; see --help");
}

static bool take_numbers(char *list)
{
    char *name;
    while ((name = strsep(&list, ",")) != NULL) {
        char *digits = name;
        (void)strsep(&digits, "=");
        if (digits == NULL) {
            return arguments_refuse(OPTION, FORM);
        }
        if (!take_number(name, digits)) {
            return false;
        }
    }
    return true;
}

/* What a kind of stand can only refuse as a whole. */
static bool fits(void)
{
    return (profile.counts_per_deg != 0.0 && profile.silence_ms / 2U >= profile.cycle_ms &&
            profile.watch_ms / 2U >= profile.cycle_ms) ||
           arguments_refuse(OPTION,
                            "needs counts_per_deg other than 0, and silence_ms and watch_ms of two cycle_ms or "
                            "more");
}

bool positioner_option_take(void *options, const char *value)
{
    (void)options;
#ifndef TUMBLE_HAS_MODBUS
    (void)value;
    return arguments_refuse(OPTION, "this program was built without libmodbus");
#endif
    if (strncmp(value, SCHEME, strlen(SCHEME)) != 0 || strlen(value) >= sizeof text) {
        return arguments_refuse(OPTION, FORM);
    }
    (void)strcpy(text, value + strlen(SCHEME));
    char *list = text;
    char *const address = strsep(&list, ",");
    if (!arguments_cut_address(address, &host, &port) || !is_port(port)) {
        return arguments_refuse(OPTION, FORM);
    }
    return take_numbers(list) && fits();
}

#ifdef TUMBLE_HAS_MODBUS
static modbus_link_t modbus_link;
static tumble_positioner_t positioner;
#endif

bool positioner_option_use(tumble_navcomp_config_t *config)
{
    if (host == NULL) {
        return true;
    }
#ifdef TUMBLE_HAS_MODBUS
    profile.link = &modbus_link.link;
    config->stand = &tumble_positioner_kind;
    config->stand_profile = &profile;
    config->stand_memory = &positioner;
    config->stand_bytes = sizeof positioner;
    config->stand_node = 0;
    return modbus_link_open(&modbus_link, host, port, unit, (uint16_t)(profile.silence_ms / PARTS_OF_SILENCE));
#else
    (void)config;
    return false;
#endif
}

void positioner_option_close(void)
{
#ifdef TUMBLE_HAS_MODBUS
    if (host != NULL) {
        modbus_link_close(&modbus_link);
    }
#endif
}
