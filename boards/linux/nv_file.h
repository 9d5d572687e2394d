/* nv_file.h - the firmware's non-volatile memory (tumble/port.h) as a file that behaves like flash.
 *
 * The file holds nothing but the memory's bytes. A granule that is not erased is not programmed: TUMBLE_E_NV. A thread
 * of its own writes, and waits until the medium has what was written; an operation that takes it longer than 2 ms
 * answers TUMBLE_E_PORT_BUSY, so that a slow disk does not hold up the bus. One process at a time: the file is locked.
 * Not re-entrant on one object.
 */
#ifndef TUMBLE_LINUX_NV_FILE_H
#define TUMBLE_LINUX_NV_FILE_H

#include "tumble/port.h"

#include <pthread.h>
#include <stdint.h>

#define NV_FILE_SECTOR 4096U
#define NV_FILE_GRANULE 8U
#define NV_FILE_SECTORS 16U
#define NV_FILE_BYTES (NV_FILE_SECTOR * NV_FILE_SECTORS)

typedef enum { NV_FILE_IDLE = 0, NV_FILE_RUNNING, NV_FILE_ENDED, NV_FILE_CLOSING } nv_file_state_t;

typedef struct {
    tumble_nv_t nv; /* what the firmware gets; keeps a pointer to this object */
    int fd;
    pthread_t thread;
    pthread_mutex_t mutex; /* of all below */
    pthread_cond_t changed;
    nv_file_state_t state;
    uint32_t offset; /* of the operation under way, or ended and not yet told */
    uint32_t size;
    uint8_t bytes[NV_FILE_SECTOR]; /* what it writes */
    tumble_status_t result;
} nv_file_t;

/* Open the file, made and erased if it is not there, and lock it. Null, or what is wrong, for one line to the user;
 * nothing stays open then. A file of another size is refused; one that is cut off and holds nothing but erased bytes
 * was being made when the process was killed, and is completed. */
const char *nv_file_open(nv_file_t *file, const char *path);

/* Let an operation end that is under way, then close. */
void nv_file_close(nv_file_t *file);

#endif
