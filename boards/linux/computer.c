#define _POSIX_C_SOURCE 200809L

#include "computer.h"

#include "navcomp/uncertainty.h"

#define US_PER_S 1000000U

can_socket_status_t computer_open_bus(computer_t *self, const char *interface)
{
    const can_socket_status_t status = port_linux_open(&self->bus, &self->port, interface);
    self->epoch_us = port_linux_utc_us();
    return status;
}

const char *computer_open_memory(computer_t *self, const char *path)
{
    const char *const wrong = nv_file_open(&self->file, path);
    self->port.nv = (wrong == NULL) ? &self->file.nv : NULL;
    return wrong;
}

static void add_keeper(computer_t *self, tumble_navcomp_config_t *config, const char *serial,
                       const tumble_sets_settings_t *settings)
{
    tumble_thermal_sets_init(&self->thermal_sets);
    self->keeper_config = (tumble_keeper_config_t){
        .sets = {.serial = serial,
                 .settings = settings,
                 .whole_step = tumble_whole_step,
                 .whole_work = &self->whole_work,
                 .thermal = &self->thermal_sets},
        .uncertainty = tumble_navcomp_uncertainty,
        .norm = tumble_navcomp_norm,
        .stand_view = tumble_stand_view,
        .stand_memory = &self->stand_memory,
        .inclinations_view = tumble_inclinations_view,
        .inclinations_memory = &self->inclinations_memory,
    };
    self->keeper.config = &self->keeper_config;
    config->keeping = &tumble_keeper_calls;
    config->keeper = &self->keeper;
}

tumble_status_t computer_init(computer_t *self, tumble_navcomp_t *navcomp, tumble_navcomp_config_t *config,
                              const char *serial, const tumble_sets_settings_t *settings)
{
    self->navcomp = navcomp;
    if (self->port.nv == NULL) {
        return tumble_navcomp_init(navcomp, config);
    }
    add_keeper(self, config, serial, settings);
    const tumble_status_t status = tumble_navcomp_init(navcomp, config);
    return (status == TUMBLE_OK) ? tumble_keeper_set_utc(&self->keeper, self->epoch_us / US_PER_S) : status;
}

bool computer_open_events(computer_t *self)
{
    return events_open(&self->events, self->bus.can.fd);
}

void computer_step(computer_t *self, uint64_t *now_us)
{
    const uint64_t due_us = tumble_navcomp_next_deadline_us(self->navcomp);
    *now_us = port_linux_now_us(&self->bus);
    if (due_us > 0U && *now_us > due_us && *now_us - due_us > self->latest_us) {
        self->latest_us = *now_us - due_us;
    }
    tumble_navcomp_step(self->navcomp);
}

int computer_wait(computer_t *self)
{
    events_wait(&self->events, self->bus.start_us + tumble_navcomp_next_deadline_us(self->navcomp));
    return events_signal(&self->events);
}

const tumble_keeper_t *computer_keeper(const computer_t *self)
{
    return (self->port.nv != NULL) ? &self->keeper : NULL;
}

void computer_close(computer_t *self)
{
    can_socket_count_drops(&self->bus.can);
    events_close(&self->events);
    port_linux_close(&self->bus);
    if (self->port.nv != NULL) {
        nv_file_close(&self->file);
    }
}
