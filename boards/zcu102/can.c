#include "can.h"

#include "io.h"

#include <stddef.h>
#include <string.h>

/* Registers. */
enum {
    RESET = 0x00,
    MODE = 0x04,
    PRESCALER = 0x08,
    SEGMENTS = 0x0C,
    STATUS = 0x18,
    EVENTS = 0x1C,
    EVENTS_ENABLE = 0x20,
    EVENTS_CLEAR = 0x24,
    TX_ID = 0x30,
    TX_LENGTH = 0x34,
    TX_DATA1 = 0x38,
    TX_DATA2 = 0x3C,
    RX_ID = 0x50,
    RX_LENGTH = 0x54,
    RX_DATA1 = 0x58,
    RX_DATA2 = 0x5C,
    FILTERS_ENABLE = 0x60,
    FILTER_MASK = 0x64, /* and every 8 bytes */
    FILTER_ID = 0x68
};

#define RESET_SOFTWARE 1U
#define RESET_ENABLE 2U
#define MODE_NORMAL 0U
#define STATUS_TX_FULL (1U << 10)
#define EVENT_RX_OVERFLOW (1U << 6)
#define EVENT_RX_NOT_EMPTY (1U << 7)
#define EVENT_BUS_OFF (1U << 9)
#define ALL_EVENTS 0x7FFFU
#define LENGTH_SHIFT 28U
#define RECOVERY_BITS (128U * 11U) /* of recessive bus, after which a node may come back */
#define US_PER_S 1000000U

/* How the bits of an identifier word lie: the shift of a standard identifier, and what marks other frames. */
typedef struct {
    uint32_t shift;
    uint32_t foreign;
    bool low_byte_first;
} layout_t;

static const layout_t LAYOUTS[] = {
    [ZCU102_CAN_SILICON] = {21U, (1U << 20) | (1U << 19), false}, /* remote, extended */
    [ZCU102_CAN_EMULATED] = {0U, 7U << 29, true},                 /* extended, remote, error */
};

static uint32_t get(const zcu102_can_t *can, uint32_t offset)
{
    return zcu102_read(can->config->base + offset);
}

static void set(const zcu102_can_t *can, uint32_t offset, uint32_t value)
{
    zcu102_write(can->config->base + offset, value);
}

static void count(uint32_t *counter)
{
    if (*counter != UINT32_MAX) {
        (*counter)++;
    }
}

/* Filters can be written while they are off; without any in use everything passes. */
static void set_filters(const zcu102_can_t *can)
{
    const zcu102_can_config_t *config = can->config;
    const layout_t *layout = &LAYOUTS[config->layout];
    static const zcu102_can_filter_t EVERYTHING = {0, 0};
    const bool open = (config->filters == NULL);
    const uint32_t filters = open ? 1U : config->filter_count;
    set(can, FILTERS_ENABLE, 0);
    for (uint32_t n = 0; n < filters; n++) {
        const zcu102_can_filter_t *filter = open ? &EVERYTHING : &config->filters[n];
        set(can, FILTER_MASK + (8U * n), ((uint32_t)filter->mask << layout->shift) | layout->foreign);
        set(can, FILTER_ID + (8U * n), (uint32_t)filter->id << layout->shift);
    }
    set(can, FILTERS_ENABLE, (1U << filters) - 1U);
}

/* Timing and filters can only be set while the controller is off. */
static void join(const zcu102_can_t *can)
{
    const zcu102_bit_timing_t *timing = &can->timing;
    set(can, RESET, RESET_SOFTWARE);
    set(can, PRESCALER, timing->prescaler - 1U);
    set(can, SEGMENTS, ((timing->jump - 1U) << 7) | ((timing->segment2 - 1U) << 4) | (timing->segment1 - 1U));
    set(can, MODE, MODE_NORMAL);
    set_filters(can);
    set(can, EVENTS_CLEAR, ALL_EVENTS);
    set(can, EVENTS_ENABLE, EVENT_RX_NOT_EMPTY | EVENT_RX_OVERFLOW | EVENT_BUS_OFF);
    set(can, RESET, RESET_ENABLE);
}

tumble_status_t zcu102_can_init(zcu102_can_t *can, const zcu102_can_config_t *config)
{
    if ((can == NULL) || (config == NULL) || (config->filter_count > ZCU102_CAN_FILTERS)) {
        return TUMBLE_E_ARGUMENT;
    }
    *can = (zcu102_can_t){.config = config};
    const tumble_status_t status = zcu102_bit_timing(config->clock_hz, config->bits_per_second, &can->timing);
    if (status == TUMBLE_OK) {
        join(can);
    }
    return status;
}

static void leave(zcu102_can_t *can, uint64_t now_us)
{
    const uint32_t rate = can->config->bits_per_second;
    count(&can->counters.bus_off);
    can->away = true;
    can->rejoin_us = now_us + ((((uint64_t)RECOVERY_BITS * US_PER_S) + (rate - 1U)) / rate);
    set(can, RESET, RESET_SOFTWARE);
}

/* What the controller has noticed since the last call. False: it is off the bus. */
static bool look_after(zcu102_can_t *can, uint64_t now_us)
{
    if (can->away && (now_us >= can->rejoin_us)) {
        can->away = false;
        join(can);
    }
    if (can->away) {
        return false;
    }
    const uint32_t events = get(can, EVENTS);
    if ((events & EVENT_RX_OVERFLOW) != 0U) {
        count(&can->counters.rx_overflow);
        set(can, EVENTS_CLEAR, EVENT_RX_OVERFLOW);
    }
    if ((events & EVENT_BUS_OFF) != 0U) {
        leave(can, now_us);
        return false;
    }
    return true;
}

static uint32_t pack(const uint8_t bytes[4], bool low_byte_first)
{
    uint32_t word = 0;
    for (uint32_t i = 0; i < 4U; i++) {
        word |= (uint32_t)bytes[i] << (8U * (low_byte_first ? i : (3U - i)));
    }
    return word;
}

static void unpack(uint32_t word, uint8_t bytes[4], bool low_byte_first)
{
    for (uint32_t i = 0; i < 4U; i++) {
        bytes[i] = (uint8_t)(word >> (8U * (low_byte_first ? i : (3U - i))));
    }
}

tumble_status_t zcu102_can_send(zcu102_can_t *can, const tumble_can_frame_t *frame, uint64_t now_us)
{
    const layout_t *layout = &LAYOUTS[can->config->layout];
    uint8_t data[TUMBLE_CAN_MAX_BYTES] = {0};
    if ((frame->id > TUMBLE_CAN_MAX_ID) || (frame->length > TUMBLE_CAN_MAX_BYTES)) {
        return TUMBLE_E_ARGUMENT;
    }
    if (!look_after(can, now_us)) {
        return TUMBLE_E_PORT_DOWN;
    }
    if ((get(can, STATUS) & STATUS_TX_FULL) != 0U) {
        count(&can->counters.busy);
        return TUMBLE_E_PORT_BUSY;
    }
    (void)memcpy(data, frame->data, frame->length);
    set(can, TX_ID, (uint32_t)frame->id << layout->shift);
    set(can, TX_LENGTH, (uint32_t)frame->length << LENGTH_SHIFT);
    set(can, TX_DATA1, pack(&data[0], layout->low_byte_first));
    set(can, TX_DATA2, pack(&data[4], layout->low_byte_first)); /* all four words, always: the last one sends */
    count(&can->counters.sent);
    return TUMBLE_OK;
}

/* Take one frame out of the queue: all four words, always. False: not one of ours. */
static bool take(const zcu102_can_t *can, tumble_can_frame_t *frame)
{
    const layout_t *layout = &LAYOUTS[can->config->layout];
    const uint32_t id = get(can, RX_ID);
    const uint32_t length = get(can, RX_LENGTH) >> LENGTH_SHIFT;
    uint8_t data[TUMBLE_CAN_MAX_BYTES];
    unpack(get(can, RX_DATA1), &data[0], layout->low_byte_first);
    unpack(get(can, RX_DATA2), &data[4], layout->low_byte_first);
    set(can, EVENTS_CLEAR, EVENT_RX_NOT_EMPTY); /* it stays set while there is another */
    *frame = (tumble_can_frame_t){.id = (uint16_t)((id >> layout->shift) & TUMBLE_CAN_MAX_ID)};
    frame->length = (uint8_t)((length < TUMBLE_CAN_MAX_BYTES) ? length : TUMBLE_CAN_MAX_BYTES);
    (void)memcpy(frame->data, data, frame->length);
    return (id & layout->foreign) == 0U;
}

tumble_status_t zcu102_can_receive(zcu102_can_t *can, tumble_can_frame_t *frame, uint64_t now_us)
{
    if (!look_after(can, now_us)) {
        return TUMBLE_E_PORT_DOWN;
    }
    for (uint32_t looked_at = 0; looked_at < ZCU102_CAN_QUEUE; looked_at++) {
        if ((get(can, EVENTS) & EVENT_RX_NOT_EMPTY) == 0U) {
            return TUMBLE_E_PORT_EMPTY;
        }
        if (take(can, frame)) {
            count(&can->counters.received);
            return TUMBLE_OK;
        }
        count(&can->counters.foreign);
    }
    return TUMBLE_E_PORT_EMPTY;
}
