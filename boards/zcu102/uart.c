#include "uart.h"

#include "io.h"

#include <string.h>

#define UART 0xFF000000U
#define CONTROL (UART + 0x00U)
#define MODE (UART + 0x04U)
#define BAUD_GENERATOR (UART + 0x18U)
#define STATUS (UART + 0x2CU)
#define FIFO (UART + 0x30U)
#define BAUD_DIVIDER (UART + 0x34U)

#define CONTROL_RESET 0x03U /* both directions */
#define CONTROL_ON 0x14U    /* transmitter and receiver */
#define MODE_8N1 0x20U
#define STATUS_FULL (1U << 4)

void zcu102_uart_init(void)
{
    zcu102_write(CONTROL, CONTROL_RESET);
    zcu102_write(MODE, MODE_8N1);
    zcu102_write(BAUD_GENERATOR, 124U); /* 100 MHz / 124 / (6 + 1) = 115207 baud */
    zcu102_write(BAUD_DIVIDER, 6U);
    zcu102_write(CONTROL, CONTROL_ON);
}

static void put_byte(char byte)
{
    while ((zcu102_read(STATUS) & STATUS_FULL) != 0U) {
        /* a byte leaves every 87 us */
    }
    zcu102_write(FIFO, (uint8_t)byte);
}

void zcu102_put(const char *text)
{
    for (; *text != '\0'; text++) {
        put_byte(*text);
    }
}

void zcu102_put_whole(uint64_t value)
{
    char digits[21] = {0};
    unsigned at = sizeof digits - 1U;
    do {
        at--;
        digits[at] = (char)('0' + (char)(value % 10U));
        value /= 10U;
    } while (value != 0U);
    zcu102_put(&digits[at]);
}

void zcu102_put_hex(uint64_t value, unsigned digits)
{
    for (unsigned i = digits; i > 0U; i--) {
        put_byte("0123456789abcdef"[(value >> (4U * (i - 1U))) & 0xFU]);
    }
}

void zcu102_put_bits(double value)
{
    uint64_t bits;
    (void)memcpy(&bits, &value, sizeof bits);
    zcu102_put_hex(bits, 16);
}
