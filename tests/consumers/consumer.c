/* consumer.c - a program of somebody else's. Its warning, about a variable that nobody uses, is its own affair. */
#include <stdio.h>
#include <tumble/core.h>

int main(void)
{
    int forgotten;
    const tumble_status_t status = tumble_schedule_validate(&tumble_schedule_paper, NULL);
    printf("%s %s\n", TUMBLE_VERSION, tumble_status_name(status));
}
