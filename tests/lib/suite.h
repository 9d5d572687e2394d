/* suite.h - a file of Unity tests as a suite of a program, which runs the suites of all its files (suite.cmake).
 *
 * At the end of test_NAME.c, instead of setUp, tearDown and main:
 *
 *     SUITE(NAME, set_up, NULL)
 *     {
 *         RUN_TEST(test_it_does);
 *     }
 */
#ifndef TUMBLE_TESTS_SUITE_H
#define TUMBLE_TESTS_SUITE_H

#include "unity.h"

typedef struct {
    const char *file;
    void (*run)(void);
    void (*before)(void); /* each case; NULL: nothing */
    void (*after)(void);  /* likewise, also when the case has failed */
} suite_t;

#define SUITE(name, before_each, after_each)                                                                           \
    static void run_##name(void);                                                                                      \
    const suite_t suite_##name = {__FILE__, run_##name, before_each, after_each};                                      \
    static void run_##name(void)

extern const suite_t *const suites[]; /* of the program, the last one NULL */

#endif
