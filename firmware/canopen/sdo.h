/* sdo.h - SDO (CiA 301, 7.2.4.3): server and client, expedited and segmented. Block transfer is refused.
 *
 * Neither end waits. `receive` takes a frame in, `step` sends what is due and watches the time; a frame that the port
 * has no room for is kept and offered again. One transfer at a time per end. Not re-entrant.
 */
#ifndef TUMBLE_CANOPEN_SDO_H
#define TUMBLE_CANOPEN_SDO_H

#include "canopen/dictionary.h"
#include "canopen/link.h"
#include "tumble/status.h"

#include <stdbool.h>
#include <stdint.h>

#define TUMBLE_SDO_REQUEST_ID 0x600U          /* + node: client to server */
#define TUMBLE_SDO_RESPONSE_ID 0x580U         /* + node: server to client */
#define TUMBLE_SDO_SECOND_REQUEST_ID 0x400U   /* the same of a second server, 1201h: so that two clients can talk to */
#define TUMBLE_SDO_SECOND_RESPONSE_ID 0x380U  /* one node at the same time */
#define TUMBLE_SDO_SERVER_TIMEOUT_US 1000000U /* of a client that falls silent within a segmented transfer */
#define TUMBLE_SDO_CLIENT_TIMEOUT_US 500000U  /* of one answer of a server */

typedef enum {
    TUMBLE_SDO_IDLE = 0,
    TUMBLE_SDO_UPLOAD,
    TUMBLE_SDO_DOWNLOAD,
    TUMBLE_SDO_LATER /* server: written, and its answer will be told */
} tumble_sdo_transfer_t;

/* Server. A value is read whole when its upload starts and written whole when its download ends, so that neither is
 * torn. While an answer waits for the port, a further request (which no correct client sends) is dropped, counted. */
typedef struct {
    uint8_t subindex;
    uint8_t transfer; /* tumble_sdo_transfer_t */
    uint8_t size;     /* upload: bytes in all; download: bytes announced, 0 if none were */
    uint8_t done;     /* bytes moved so far */
    uint8_t toggle;   /* 0x00 or 0x10: what the next segment must carry */
    bool answer_due;
    bool held;            /* the owner's to set: writes to what carries process data are refused; see receive */
    bool service;         /* likewise: TUMBLE_ACCESS_SERVICE may be written */
    uint16_t dropped;     /* requests dropped: not eight bytes long, or sent before the last one was answered */
    uint16_t aborted;     /* transfers refused or ended by an abort, either side's */
    uint16_t index;       /* of the transfer, for aborts */
    uint16_t response_id; /* of its answers */
    uint64_t deadline_us; /* TUMBLE_NEVER: no transfer under way */
    tumble_entry_t entry; /* download: of the object */
    uint8_t answer[TUMBLE_CAN_MAX_BYTES];
    uint8_t bytes[TUMBLE_MAX_OBJECT_BYTES];
    struct tumble_second_server *second; /* of the same node (node.h); null: it has none */
} tumble_sdo_server_t;

/* `response_id`: TUMBLE_SDO_RESPONSE_ID or TUMBLE_SDO_SECOND_RESPONSE_ID, + node. */
void tumble_sdo_server_init(tumble_sdo_server_t *server, uint16_t response_id);

/* Take a request (a frame that is known by its identifier, TUMBLE_SDO_REQUEST_ID + node). While the server is `held`, 1016h,
 * 1017h, 1029h, the first two PDOs of each direction (1400h, 1600h, 1800h, 1A00h and those after them) and objects of
 * TUMBLE_HOME_OTHER can be read only: a write is refused with TUMBLE_ABORT_DEVICE_STATE. So is one of what is
 * TUMBLE_ACCESS_SERVICE, unless the server is at `service` level. */
void tumble_sdo_server_receive(tumble_sdo_server_t *server, const tumble_dictionary_t *dictionary,
                               const tumble_can_frame_t *frame, uint64_t now_us);

/* The answer to a write for which its hook returned TUMBLE_ABORT_LATER: TUMBLE_ABORT_NONE or the reason of a refusal.
 * Without effect when the client gave up meanwhile, or asked for something else. */
void tumble_sdo_server_answer(tumble_sdo_server_t *server, tumble_abort_t refusal);

/* Send the answer that is due; abort a transfer whose client fell silent. */
void tumble_sdo_server_step(tumble_sdo_server_t *server, tumble_link_t *link, uint64_t now_us);

/* Forget transfer and answer, without a word to the client: SDO does not exist in this NMT state. */
void tumble_sdo_server_drop(tumble_sdo_server_t *server);

/* The next moment at which step has something to do; one that is over: at once. */
uint64_t tumble_sdo_server_next_us(const tumble_sdo_server_t *server);

/* Client. Ask with read or write, then look at `result` until it is no longer TUMBLE_E_SDO_BUSY. */
typedef struct {
    tumble_status_t result;
    uint8_t subindex;
    uint8_t node;     /* the server's */
    uint8_t transfer; /* tumble_sdo_transfer_t */
    uint8_t phase;    /* private */
    uint8_t capacity; /* upload: room for it */
    uint8_t size;     /* bytes to move; upload: as the server announced, 0 if it did not */
    uint8_t done;     /* bytes moved */
    uint8_t toggle;
    bool request_due;
    uint16_t ignored; /* answers that belong to no request: late, from before a timeout, malformed */
    uint16_t index;
    uint16_t below;        /* TUMBLE_SDO_TO_FIRST or TUMBLE_SDO_TO_SECOND; not to be changed within a transfer */
    uint8_t *sink;         /* upload: the caller's memory, or `value` below */
    const uint8_t *source; /* download: likewise */
    uint32_t abort;        /* why the last transfer failed: the server's code or this end's; 0: it did not */
    uint64_t deadline_us;  /* TUMBLE_NEVER: not waiting */
    uint8_t request[TUMBLE_CAN_MAX_BYTES];
    uint8_t value[8];
} tumble_sdo_client_t;

/* Which server of the node it asks: by how much identifiers are below those of the first. */
#define TUMBLE_SDO_TO_FIRST 0U
#define TUMBLE_SDO_TO_SECOND (TUMBLE_SDO_REQUEST_ID - TUMBLE_SDO_SECOND_REQUEST_ID)

/* For the first server of a node. */
void tumble_sdo_client_init(tumble_sdo_client_t *client);

/* Start to read an object of at most 8 bytes into the client's own memory (tumble_sdo_client_u32 and its like take it
 * from there). Returns TUMBLE_OK (started), TUMBLE_E_SDO_BUSY, TUMBLE_E_ARGUMENT (node not 1 to 127). */
tumble_status_t tumble_sdo_client_read(tumble_sdo_client_t *client, uint8_t node, uint16_t index, uint8_t subindex);

/* The same into `data`, which must live until the end of the transfer. A value that does not fit is aborted with
 * TUMBLE_ABORT_MEMORY. Capacity 1 to 255. */
tumble_status_t tumble_sdo_client_read_into(tumble_sdo_client_t *client, uint8_t node, uint16_t index, uint8_t subindex,
                                            uint8_t *data, uint8_t capacity);

/* Start to write a number: the low `size` bytes (1, 2 or 4) of `value`; a negative one as two's complement. */
tumble_status_t tumble_sdo_client_write(tumble_sdo_client_t *client, uint8_t node, uint16_t index, uint8_t subindex,
                                        uint32_t value, uint8_t size);

/* Start to write `size` (1 to 255) little-endian bytes, which must live until the end of the transfer and are not
 * changed: expedited up to 4 bytes, segmented beyond. */
tumble_status_t tumble_sdo_client_write_from(tumble_sdo_client_t *client, uint8_t node, uint16_t index,
                                             uint8_t subindex, const uint8_t *data, uint8_t size);

/* Give up a transfer under way: the server is told (TUMBLE_ABORT_GENERAL), the result is TUMBLE_E_SDO_ABORTED. */
void tumble_sdo_client_cancel(tumble_sdo_client_t *client);

/* Forget it without a word to the server: SDO does not exist in this NMT state. The result of a transfer under way is
 * TUMBLE_E_SDO_ABORTED with TUMBLE_ABORT_DEVICE_STATE. */
void tumble_sdo_client_drop(tumble_sdo_client_t *client);

/* Take an answer (of any identifier; those of other nodes and servers are not this client's). */
void tumble_sdo_client_receive(tumble_sdo_client_t *client, const tumble_can_frame_t *frame);

/* Send the request that is due; end a transfer whose server fell silent. The time of the answer runs from the moment
 * that the port takes the request; a port that takes none for TUMBLE_SDO_CLIENT_TIMEOUT_US is a timeout as well. */
void tumble_sdo_client_step(tumble_sdo_client_t *client, tumble_link_t *link, uint64_t now_us);

/* How the last transfer ended: TUMBLE_OK (also before the first), TUMBLE_E_SDO_BUSY (under way), TUMBLE_E_SDO_ABORTED
 * (see `abort`), TUMBLE_E_SDO_TIMEOUT. */
tumble_status_t tumble_sdo_client_result(const tumble_sdo_client_t *client);

/* After a read that ended with TUMBLE_OK: the value's bytes and their number `done`. */
const uint8_t *tumble_sdo_client_data(const tumble_sdo_client_t *client, uint8_t *size);

/* The same as a number: little-endian, zero-extended; 0 when there is no value of 1 to 4 bytes. */
uint32_t tumble_sdo_client_u32(const tumble_sdo_client_t *client);

/* The next moment at which step has something to do; one that is over: at once. */
uint64_t tumble_sdo_client_next_us(const tumble_sdo_client_t *client);

#endif
