#include "suite.h"

static const suite_t *running;

void setUp(void)
{
    if (running->around->before != NULL) {
        running->around->before();
    }
}

void tearDown(void)
{
    if (running->around->after != NULL) {
        running->around->after();
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
