#define _POSIX_C_SOURCE 200809L

#include "modbus_link.h"

#include <errno.h>
#include <modbus.h>
#include <signal.h>
#include <string.h>

#define US_PER_MS 1000U
#define MS_PER_S 1000U

/* The thread. */

static bool connect_to(modbus_link_t *self)
{
    self->connected = self->connected || modbus_connect(self->modbus) == 0;
    return self->connected;
}

/* It has understood, and will not; all other exceptions may be over by the next time. */
static bool is_refusal(int error)
{
    return error == EMBXILFUN || error == EMBXILADD || error == EMBXILVAL;
}

static tumble_status_t exchange(modbus_link_t *self)
{
    const tumble_exchange_t *const asked = &self->exchange;
    bool good = connect_to(self);
    if (good && asked->writes > 0U) {
        good = modbus_write_registers(self->modbus, asked->write_at, asked->writes, asked->values) == asked->writes;
    }
    if (good && modbus_read_registers(self->modbus, asked->read_at, asked->reads, self->values) == asked->reads) {
        return TUMBLE_OK;
    }
    if (self->connected && is_refusal(errno)) {
        return TUMBLE_E_FRAME;
    }
    if (self->connected) {
        modbus_close(self->modbus);
        self->connected = false;
    }
    return TUMBLE_E_PORT_DOWN;
}

static void *serve(void *context)
{
    modbus_link_t *const self = context;
    (void)pthread_mutex_lock(&self->mutex);
    while (!self->closing) {
        if (!self->under_way) {
            (void)pthread_cond_wait(&self->changed, &self->mutex);
            continue;
        }
        (void)pthread_mutex_unlock(&self->mutex); /* while it is under way nobody else touches the exchange */
        const tumble_status_t answer = exchange(self);
        (void)pthread_mutex_lock(&self->mutex);
        self->answer = answer;
        self->under_way = false;
    }
    (void)pthread_mutex_unlock(&self->mutex);
    return NULL;
}

/* The link. The thread holds the mutex for moments only. */

static tumble_status_t begin(void *context, const tumble_exchange_t *asked)
{
    modbus_link_t *const self = context;
    (void)pthread_mutex_lock(&self->mutex);
    const bool busy = self->under_way;
    if (!busy) {
        self->exchange = *asked;
        self->under_way = true;
        (void)pthread_cond_signal(&self->changed);
    }
    (void)pthread_mutex_unlock(&self->mutex);
    return busy ? TUMBLE_E_PORT_BUSY : TUMBLE_OK;
}

static tumble_status_t end(void *context, uint16_t values[TUMBLE_EXCHANGE_REGISTERS])
{
    modbus_link_t *const self = context;
    (void)pthread_mutex_lock(&self->mutex);
    const tumble_status_t status = self->under_way ? TUMBLE_E_PORT_BUSY : self->answer;
    if (status == TUMBLE_OK) {
        memcpy(values, self->values, sizeof self->values);
    }
    (void)pthread_mutex_unlock(&self->mutex);
    return status;
}

/* Signals are for the program's own loop. */
static bool start_thread(modbus_link_t *self)
{
    sigset_t all;
    sigset_t before;
    (void)pthread_mutex_init(&self->mutex, NULL);
    (void)pthread_cond_init(&self->changed, NULL);
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, &before);
    errno = pthread_create(&self->thread, NULL, serve, self);
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    return errno == 0;
}

bool modbus_link_open(modbus_link_t *self, const char *host, const char *port, uint8_t unit, uint16_t timeout_ms)
{
    *self = (modbus_link_t){.link = {.context = self, .begin = begin, .end = end}, .answer = TUMBLE_E_PORT_DOWN};
    self->modbus = modbus_new_tcp_pi(host, port);
    if (self->modbus == NULL) {
        return false;
    }
    (void)modbus_set_slave(self->modbus, unit);
    (void)modbus_set_response_timeout(self->modbus, timeout_ms / MS_PER_S, timeout_ms % MS_PER_S * US_PER_MS);
    (void)modbus_set_byte_timeout(self->modbus, 0, 0); /* the time for the answer holds for all of it */
    if (start_thread(self)) {
        return true;
    }
    modbus_free(self->modbus);
    return false;
}

void modbus_link_close(modbus_link_t *self)
{
    (void)pthread_mutex_lock(&self->mutex);
    self->closing = true;
    (void)pthread_cond_signal(&self->changed);
    (void)pthread_mutex_unlock(&self->mutex);
    (void)pthread_join(self->thread, NULL);
    modbus_close(self->modbus);
    modbus_free(self->modbus);
    (void)pthread_cond_destroy(&self->changed);
    (void)pthread_mutex_destroy(&self->mutex);
}
