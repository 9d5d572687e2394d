#define _POSIX_C_SOURCE 200809L

#include "bench/lock_step.h"

#include "bench/interrupt.h"
#include "core/bytes.h"

#include <errno.h>
#include <string.h>
#include <sys/socket.h>

#define TO_FIRST_FRAME 0x80000001U /* and the end of an answer */
#define TO_MOMENT 0x80000002U      /* and the moment of a frame */

const char *bench_lock_step_open(bench_lock_step_t *step, int descriptor)
{
    int kind = 0;
    socklen_t size = sizeof kind;
    *step = (bench_lock_step_t){.socket = descriptor};
    if (descriptor >= 0 && (getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &kind, &size) != 0 || kind != SOCK_STREAM)) {
        return "is no open stream socket";
    }
    return NULL;
}

static void flush(bench_lock_step_t *step)
{
    const uint8_t *rest = step->out;
    while (!step->left && step->out_size > 0U) {
        const ssize_t sent = send(step->socket, rest, step->out_size, MSG_NOSIGNAL);
        if (sent >= 0) {
            rest += sent;
            step->out_size -= (uint32_t)sent;
        } else if (errno != EINTR) {
            step->left = true;
        }
    }
    step->out_size = 0;
}

/* The next record to be sent. */
static uint8_t *put(bench_lock_step_t *step)
{
    if (step->out_size == sizeof step->out) {
        flush(step);
    }
    uint8_t *const record = step->out + step->out_size;
    step->out_size += BENCH_GUEST_RECORD;
    return record;
}

static void put_moment(bench_lock_step_t *step, uint32_t kind, uint64_t time_us)
{
    uint8_t *const record = put(step);
    (void)memset(record, 0, BENCH_GUEST_RECORD);
    tumble_put_u32(record, kind);
    record[4] = sizeof time_us;
    tumble_put_u32(record + 8, (uint32_t)time_us);
    tumble_put_u32(record + 12, (uint32_t)(time_us >> 32));
}

static void receive(bench_lock_step_t *step, uint8_t *record)
{
    size_t have = 0;
    while (!step->left && have < BENCH_GUEST_RECORD) {
        const ssize_t got = recv(step->socket, record + have, BENCH_GUEST_RECORD - have, 0);
        if (got > 0) {
            have += (size_t)got;
        } else {
            step->left = got == 0 || errno != EINTR || bench_interrupted();
        }
    }
}

static void take(bench_lock_step_t *step, bench_world_t *world, const uint8_t *record)
{
    const uint32_t kind = tumble_get_u32(record);
    if (kind == TO_FIRST_FRAME || kind == TO_MOMENT) {
        step->asked = true;
        step->stops = kind == TO_FIRST_FRAME;
        step->until_us = (uint64_t)tumble_get_u32(record + 12) << 32 | tumble_get_u32(record + 8);
    } else {
        step->left = !bench_guests_read(world, BENCH_BUS_GUEST, record);
    }
}

/* All that was asked for has been done. */
static void answer(bench_lock_step_t *step, bench_world_t *world)
{
    const bool early = step->stops && step->out_size > 0U;
    if (!early) {
        bench_world_pass(world, step->until_us);
    }
    put_moment(step, TO_FIRST_FRAME, world->clock.now_us);
    flush(step);
    step->asked = false;
}

bool bench_lock_step_wait(bench_lock_step_t *step, bench_world_t *world)
{
    uint8_t record[BENCH_GUEST_RECORD];
    while (!step->left) {
        const bool told = step->stops && step->out_size > 0U;
        if (step->asked && !told && bench_world_next_us(world) <= step->until_us) {
            return !bench_interrupted();
        }
        if (step->asked) {
            answer(step, world);
        }
        receive(step, record);
        if (!step->left) {
            take(step, world, record);
        }
    }
    return false;
}

void bench_lock_step_tell(bench_lock_step_t *step, uint64_t time_us, uint8_t sender, const tumble_can_frame_t *frame)
{
    if (step->socket >= 0 && sender != BENCH_BUS_GUEST) {
        put_moment(step, TO_MOMENT, time_us);
        bench_guests_write(put(step), frame);
    }
}
