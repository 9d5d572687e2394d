/* computer.h - the navigation computer on Linux: the firmware with its port on a CAN interface, its memory in a file, and
 * what it waits for between two steps.
 *
 *     computer_open_bus(&self, "can0");       fills in self.port
 *     computer_open_memory(&self, "nv.bin");  or not: then nothing is kept
 *     computer_init(&self, &navcomp, &config, serial, &settings);
 *     computer_open_events(&self);
 *     do { computer_step(&self, &now_us); } while (computer_wait(&self) == 0);
 *     computer_close(&self);
 *
 * Nothing here writes a line: what happens is told by the hooks of `config`, by `bus.on_frame` and by what may be read of
 * the firmware after a step. There is one such computer in a process.
 */
#ifndef TUMBLE_LINUX_COMPUTER_H
#define TUMBLE_LINUX_COMPUTER_H

#include "events.h"
#include "nv_file.h"
#include "port_linux.h"

#include "navcomp/keeper.h"
#include "navcomp/views.h"
#include "tumble/navcomp.h"

typedef struct {
    tumble_port_t port;
    port_linux_t bus;
    uint64_t epoch_us;  /* UTC at the port's time 0 */
    uint64_t latest_us; /* the longest that a step came after its time */
    tumble_navcomp_t *navcomp;
    events_t events;
    nv_file_t file; /* in use if the port has a memory; and so are these */
    tumble_keeper_t keeper;
    tumble_keeper_config_t keeper_config;
    tumble_stand_memory_t stand_memory;
    tumble_inclinations_memory_t inclinations_memory;
    tumble_whole_work_t whole_work;
    tumble_thermal_sets_t thermal_sets;
} computer_t;

/* As can_socket_open. */
can_socket_status_t computer_open_bus(computer_t *self, const char *interface);

/* As nv_file_open. */
const char *computer_open_memory(computer_t *self, const char *path);

/* The firmware as `config` says, which must stay; with a memory, what it finds is kept there for the block `serial`.
 * Calendar time is this machine's; over CAN it may be told otherwise. */
tumble_status_t computer_init(computer_t *self, tumble_navcomp_t *navcomp, tumble_navcomp_config_t *config,
                              const char *serial, const tumble_sets_settings_t *settings);

/* False: errno says why. */
bool computer_open_events(computer_t *self);

/* One step of the firmware; `now_us` becomes its time before the firmware sees it. */
void computer_step(computer_t *self, uint64_t *now_us);

/* Until a frame comes, a step is due, or a signal has come: SIGINT, SIGTERM or SIGUSR1, which is returned; else 0. */
int computer_wait(computer_t *self);

/* Who keeps what it finds; null: there is no memory. */
const tumble_keeper_t *computer_keeper(const computer_t *self);

/* Once there are no more steps. Lets the memory end what it writes. */
void computer_close(computer_t *self);

#endif
