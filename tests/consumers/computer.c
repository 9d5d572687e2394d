/* computer.c - the same with a navigation computer, which has no port and so refuses. */
#include <stdio.h>
#include <tumble/navcomp.h>

int main(void)
{
    static tumble_navcomp_t navcomp;
    static const tumble_navcomp_config_t no_port;
    printf("%s %s\n", TUMBLE_VERSION, tumble_status_name(tumble_navcomp_init(&navcomp, &no_port)));
}
