/* uart.h - the log: lines of text on the first serial port, 115200 baud. Waits while the port's queue (64 bytes) is
 * full: a line takes up to 9 ms, so it is for what happens rarely. */
#ifndef ZCU102_UART_H
#define ZCU102_UART_H

#include <stdint.h>

void zcu102_uart_init(void);
void zcu102_put(const char *text);
void zcu102_put_whole(uint64_t value);
void zcu102_put_hex(uint64_t value, unsigned digits);

/* The bits of a number, 16 hexadecimal digits. */
void zcu102_put_bits(double value);

#endif
