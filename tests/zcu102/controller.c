#include "controller.h"

#include "can.h"
#include "io.h"

#include <string.h>

controller_t controllers[2];

#define REG(c, offset) ((c)->reg[(offset) / 4U])
enum { SRR = 0x00, MSR = 0x04, BRPR = 0x08, BTR = 0x0C, SR = 0x18, ISR = 0x1C, ICR = 0x24, TXFIFO = 0x30 };
enum { RXFIFO = 0x50, AFR = 0x60, AFMR1 = 0x64, AFIR1 = 0x68, AFIR4 = 0x80 };
#define CEN 2U
#define BSOFF (1U << 9)
#define RXNEMP (1U << 7)
#define RXOFLW (1U << 6)

static controller_t *at(uint32_t address)
{
    return ((address & ~0xFFFU) == ZCU102_CAN0) ? &controllers[0] : &controllers[1];
}

static bool is_on(const controller_t *c)
{
    return (REG(c, SRR) & CEN) != 0U;
}

void controllers_init(void)
{
    memset(controllers, 0, sizeof controllers);
}

static void reset(controller_t *c)
{
    const uint32_t misuse = c->misuse;
    const uint32_t resets = c->resets + 1U;
    memset(c, 0, sizeof *c);
    c->misuse = misuse;
    c->resets = resets;
}

static void write_word(controller_t *c, uint32_t place, uint32_t value)
{
    c->misuse += (place != c->written) ? 1U : 0U;
    c->writing.word[place] = value;
    c->written = (place + 1U) % 4U;
    if (place == 3U) {
        if (c->tx_count == CONTROLLER_QUEUE || !is_on(c)) {
            c->misuse++;
            return;
        }
        c->tx[c->tx_count++] = c->writing;
    }
}

void zcu102_write(uint32_t address, uint32_t value)
{
    controller_t *c = at(address);
    const uint32_t offset = address & 0xFFFU;
    const bool fixed = offset == BRPR || offset == BTR || offset == MSR;
    if (offset == SRR && (value & 1U) != 0U) {
        reset(c);
    } else if (offset >= TXFIFO && offset < TXFIFO + 16U) {
        write_word(c, (offset - TXFIFO) / 4U, value);
    } else if (offset == ICR) {
        REG(c, ISR) &= ~value;
        REG(c, ISR) |= (c->rx_count > 0U) ? RXNEMP : 0U;
    } else if ((fixed && is_on(c)) || (offset >= AFMR1 && offset <= AFIR4 && REG(c, AFR) != 0U) ||
               (offset >= RXFIFO && offset < AFR) || offset == SR || offset == ISR) {
        c->misuse++;
    } else {
        REG(c, offset) = value;
    }
}

static uint32_t read_word(controller_t *c, uint32_t place)
{
    if (place == 0U) {
        c->misuse += (c->rx_count == 0U || c->reading != 0U) ? 1U : 0U;
        c->reading = 4;
    }
    c->misuse += (c->reading != 4U - place) ? 1U : 0U;
    c->reading--;
    const uint32_t value = c->rx[0].word[place];
    if (place == 3U && c->rx_count > 0U) {
        c->rx_count--;
        memmove(&c->rx[0], &c->rx[1], c->rx_count * sizeof c->rx[0]);
    }
    return value;
}

uint32_t zcu102_read(uint32_t address)
{
    controller_t *c = at(address);
    const uint32_t offset = address & 0xFFFU;
    if (offset >= RXFIFO && offset < RXFIFO + 16U) {
        return read_word(c, (offset - RXFIFO) / 4U);
    }
    if (offset == SR) {
        return (c->tx_count == CONTROLLER_QUEUE) ? (1U << 10) : 0U;
    }
    return REG(c, offset);
}

static bool passes(const controller_t *c, uint32_t id)
{
    bool passed = REG(c, AFR) == 0U;
    for (uint32_t n = 0; n < 4U; n++) {
        const uint32_t mask = REG(c, AFMR1 + 8U * n);
        passed = passed || (((REG(c, AFR) >> n) & 1U) != 0U && (id & mask) == (REG(c, AFIR1 + 8U * n) & mask));
    }
    return passed;
}

static void deliver(controller_t *c, const controller_frame_t *frame)
{
    if (!is_on(c) || c->dead || !passes(c, frame->word[0])) {
        return;
    }
    if (c->rx_count == CONTROLLER_QUEUE) {
        REG(c, ISR) |= RXOFLW;
        return;
    }
    c->rx[c->rx_count++] = *frame;
    REG(c, ISR) |= RXNEMP;
}

void controllers_hear(const controller_frame_t *frame)
{
    deliver(&controllers[0], frame);
    deliver(&controllers[1], frame);
}

static bool may_send(const controller_t *c)
{
    return c->tx_count > 0U && is_on(c) && !c->dead;
}

void controllers_run(uint32_t frames)
{
    for (; frames > 0U && (may_send(&controllers[0]) || may_send(&controllers[1])); frames--) {
        const bool second = !may_send(&controllers[0]) ||
                            (may_send(&controllers[1]) && controllers[1].tx[0].word[0] < controllers[0].tx[0].word[0]);
        controller_t *from = &controllers[second ? 1 : 0];
        deliver(&controllers[second ? 0 : 1], &from->tx[0]);
        from->tx_count--;
        memmove(&from->tx[0], &from->tx[1], from->tx_count * sizeof from->tx[0]);
    }
}

void controller_kill(uint32_t number)
{
    controllers[number].dead = true;
    controllers[number].tx_count = 0;
    REG(&controllers[number], ISR) |= BSOFF;
}
