/* suite.h - a file of Unity tests as a suite of a program, which runs the suites of all its files (suite.cmake).
 *
 * Every function test_...(void) of test_NAME.c is a case; the build lists them (suite_cases.cmake), in their order. Around
 * each case its set_up(void) and tear_down(void) are called, as far as it has them; or what several files share:
 *
 *     static const around_t around_each = {keeper_power_on, NULL};
 */
#ifndef TUMBLE_TESTS_SUITE_H
#define TUMBLE_TESTS_SUITE_H

#include "unity.h"

typedef struct {
    void (*before)(void); /* NULL: nothing */
    void (*after)(void);  /* likewise; also when the case has failed */
} around_t;

typedef struct {
    const char *file;
    void (*run)(void);
    const around_t *around; /* each case */
} suite_t;

extern const suite_t *const suites[]; /* of the program, the last one NULL */

#endif
