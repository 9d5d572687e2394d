#include "played_positioner.h"

#include <stddef.h>
#include <string.h>

#define HOME_MARK 0
#define POWER_ON_AT 12345

enum { STOP = 0, HOME, GO, RESET };

/* The registers. */

static uint16_t status_of(const played_positioner_t *played)
{
    const bool arrived = !played->moving && (played->order == GO || played->order == HOME) &&
                         played->table == played->goal && !played->never_arrives && !played->never_tells;
    const bool claims = arrived || (played->arrives_early && played->order == GO);
    return (uint16_t)(((played->moving && !claims) ? PLAYED_MOVING : 0) | (claims ? PLAYED_IN_POSITION : 0) |
                      (played->homed ? PLAYED_HOMED : 0) | ((played->fault != 0U) ? PLAYED_FAULT : 0) |
                      (played->watched ? PLAYED_WATCHED : 0));
}

static void read_registers(played_positioner_t *played)
{
    const uint32_t angle = (uint32_t)(played->table - played->zero);
    const uint16_t registers[TUMBLE_EXCHANGE_REGISTERS] = {0x5450,        status_of(played),       played->number,
                                                           played->fault, (uint16_t)(angle >> 16), (uint16_t)angle};
    if (played->exchange.read_at != 16U || played->exchange.reads != TUMBLE_EXCHANGE_REGISTERS) {
        played->wrong = "read other registers";
    }
    memcpy(played->values, registers, sizeof registers);
    played->values[played->spoilt] ^= played->spoils;
}

static void take_order(played_positioner_t *played, const uint16_t *registers)
{
    const int32_t target = (int32_t)(((uint32_t)registers[3] << 16) | registers[4]);
    played->number = registers[1];
    played->order = registers[2];
    played->watched = !played->never_watches;
    if (played->order == RESET) {
        played->fault = 0;
    }
    if (played->order == GO && !played->homed) {
        played->wrong = "sent an axis that is not homed";
    } else if (played->order == HOME || played->order == GO) {
        played->homed = played->homed && (played->order == GO);
        played->goal = (played->order == GO) ? target + played->zero : HOME_MARK;
        played->moving = (played->fault == 0U) && played->goal != played->table;
    } else {
        played->moving = played->moving && (played->never_stops || played->has_no_brake);
    }
    if (played->order == HOME && played->goal == played->table) {
        played->homed = true;
        played->zero = HOME_MARK;
    }
}

static void write_registers(played_positioner_t *played)
{
    const tumble_exchange_t *const exchange = &played->exchange;
    if (exchange->writes == 0U) {
        return;
    }
    played->writes++;
    if (exchange->write_at != 0U || exchange->values[0] == 0U || (exchange->writes != 1U && exchange->writes != 5U) ||
        exchange->values[2] > RESET) {
        played->wrong = "wrote what is no order";
    }
    played->watch_ms = played->now_ms + exchange->values[0];
    if (exchange->writes == 5U && exchange->values[1] != played->number && !played->deaf) {
        take_order(played, exchange->values);
    }
}

/* The link. */

static tumble_status_t begin(void *context, const tumble_exchange_t *exchange)
{
    played_positioner_t *const played = context;
    if (played->under_way) {
        return TUMBLE_E_PORT_BUSY;
    }
    played->exchange = *exchange;
    played->under_way = true;
    played->answers_ms = played->now_ms + PLAYED_LATENCY_MS;
    played->exchanges++;
    return TUMBLE_OK;
}

static tumble_status_t end(void *context, uint16_t values[TUMBLE_EXCHANGE_REGISTERS])
{
    played_positioner_t *const played = context;
    if (played->under_way) {
        return TUMBLE_E_PORT_BUSY;
    }
    memcpy(values, played->values, sizeof played->values);
    return played->answer;
}

static void answer(played_positioner_t *played)
{
    if (played->under_way && played->now_ms >= played->answers_ms) {
        played->under_way = false;
        played->answer = played->dead ? TUMBLE_E_PORT_DOWN : played->refuses ? TUMBLE_E_FRAME : TUMBLE_OK;
        if (!played->dead && !played->refuses) {
            write_registers(played);
            read_registers(played);
        }
    }
}

/* The axis. */

static void turn(played_positioner_t *played)
{
    const int32_t left = played->goal - played->table;
    const int32_t way = (left > played->counts_per_ms)    ? played->counts_per_ms
                        : (left < -played->counts_per_ms) ? -played->counts_per_ms
                                                          : left;
    const bool homing = (played->order == HOME);
    if (!played->moving) {
        return;
    }
    if (played->has_no_brake || (homing && played->never_homes)) {
        played->table += played->counts_per_ms;
        return;
    }
    played->table += way;
    if (played->table == played->goal && !played->never_arrives && !played->never_stops) {
        played->moving = false;
        played->homed = played->homed || homing;
        played->zero = homing ? HOME_MARK : played->zero;
    }
}

void played_positioner_step(played_positioner_t *played)
{
    played->now_ms++;
    answer(played);
    turn(played);
    if (played->watched && played->now_ms >= played->watch_ms) {
        played->watched = false;
        played->moving = played->moving && played->has_no_brake;
        played->order = STOP;
    }
}

void played_positioner_boot(played_positioner_t *played)
{
    played->number = 0;
    played->order = STOP;
    played->fault = 0;
    played->watched = false;
    played->homed = false;
    played->moving = false;
    played->zero = played->table;
}

void played_positioner_init(played_positioner_t *played)
{
    *played = (played_positioner_t){
        .link = {.context = played, .begin = begin, .end = end}, .table = POWER_ON_AT, .counts_per_ms = 200};
    played_positioner_boot(played);
}

double played_positioner_angle_deg(const played_positioner_t *played)
{
    return (double)played->table / PLAYED_COUNTS_PER_DEG;
}

tumble_positioner_profile_t played_positioner_profile(const played_positioner_t *played)
{
    return (tumble_positioner_profile_t){
        .link = &played->link,
        .counts_per_deg = PLAYED_COUNTS_PER_DEG,
        .window_deg = 0.05,
        .home_timeout_ms = 20000,
        .move_timeout_ms = 4000,
        .stop_timeout_ms = 300,
        .cycle_ms = 20,
        .silence_ms = 200,
        .watch_ms = 250,
    };
}
