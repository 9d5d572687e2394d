#include "suite.h"

static const suite_t *running;

void setUp(void)
{
    if (running->before != NULL) {
        running->before();
    }
}

void tearDown(void)
{
    if (running->after != NULL) {
        running->after();
    }
}

int main(void)
{
    UNITY_BEGIN();
    for (const suite_t *const *suite = suites; *suite != NULL; suite++) {
        running = *suite;
        Unity.TestFile = running->file; /* where a failure is said to be */
        running->run();
    }
    return UNITY_END();
}
