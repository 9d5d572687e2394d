/* target.h - what a test has on the board: the debugger's console and an exit status (semihosting). */
#ifndef TUMBLE_TESTS_TARGET_H
#define TUMBLE_TESTS_TARGET_H

/* One character to the console; Unity writes with it. */
void target_put(int character);

#endif
