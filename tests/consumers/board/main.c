/* main.c - a navigation computer on this board. Nobody else is on the bus: it sends its own boot-up message first. */
#include "port.h"

#include <navcomp/standard.h>
#include <stdio.h>
#include <tumble/navcomp.h>

int main(void)
{
    static tumble_drive402_t drive;
    static tumble_navcomp_t navcomp;
    static tumble_navcomp_config_t config;
    tumble_can_frame_t frame;
    config = tumble_standard_navcomp;
    config.port = &mine_ports[0];
    config.stand_memory = &drive;
    config.stand_bytes = sizeof drive;
    if (tumble_navcomp_init(&navcomp, &config) != TUMBLE_OK) {
        return 1;
    }
    tumble_navcomp_step(&navcomp);
    while (mine_ports[1].can_receive(mine_ports[1].context, &frame) == TUMBLE_OK) {
        printf("%03X\n", (unsigned)frame.id);
    }
    return 0;
}
