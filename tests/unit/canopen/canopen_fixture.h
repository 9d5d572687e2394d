/* canopen_fixture.h - a node 5 with one object of every kind, on a fake port, and frames written as text.
 *
 * The table is written by hand and not by the generator, so that the two are independent. `give` hands the node a
 * frame, `expect` takes the oldest frame that it has sent and compares it; both read bytes as hexadecimal text.
 */
#ifndef TUMBLE_TESTS_CANOPEN_FIXTURE_H
#define TUMBLE_TESTS_CANOPEN_FIXTURE_H

#include "canopen/node.h"
#include "core/bytes.h"
#include "fake_port.h"
#include "suite.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NODE 5U
#define MS UINT64_C(1000)
#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

typedef struct {
    double f64;
    double unlimited;
    int64_t i64;
    uint64_t u64;
    int32_t i32;
    uint32_t u32;
    uint32_t guarded;
    float f32;
    float unlimited32;
    int16_t i16;
    uint16_t u16;
    uint16_t u16_ro;
    uint16_t limited16;
    bool flag;
    int8_t i8;
    uint8_t u8;
    uint8_t secret;
    uint8_t record[2];
    char text[32];
} variables_t;

typedef struct {
    uint32_t unused;
    uint16_t other;
} other_t;

typedef struct {
    uint32_t device_type;
    char name[17];
    char version[3];
    double pi;
} constants_t;

#define RO TUMBLE_ACCESS_READ
#define RW (TUMBLE_ACCESS_READ | TUMBLE_ACCESS_WRITE)
#define WO TUMBLE_ACCESS_WRITE
#define MAPPED (TUMBLE_ACCESS_MAP_RECEIVE | TUMBLE_ACCESS_MAP_TRANSMIT)
#define U8 TUMBLE_TYPE_UNSIGNED8
#define U16 TUMBLE_TYPE_UNSIGNED16
#define U32 TUMBLE_TYPE_UNSIGNED32
#define TEXT TUMBLE_TYPE_VISIBLE_STRING
#define OWN(index, sub, type, access, size) {index, sub, type, TUMBLE_HOME_COMMUNICATION, access, size, 0, 0, 0, 0, 0}
#define VAR(index, sub, type, access, size, limit, member)                                                             \
    {index, sub, type, TUMBLE_HOME_VARIABLES, access, size, limit, 0, 0, offsetof(variables_t, member), 0}
#define MAPPING(index)                                                                                                 \
    OWN(index, 0, U8, RW, 1), OWN(index, 1, U32, RW, 4), OWN(index, 2, U32, RW, 4), OWN(index, 3, U32, RW, 4),         \
        OWN(index, 4, U32, RW, 4), OWN(index, 5, U32, RW, 4), OWN(index, 6, U32, RW, 4), OWN(index, 7, U32, RW, 4),    \
        OWN(index, 8, U32, RW, 4)
#define RECEIVE(index) OWN(index, 0, U8, RO, 1), OWN(index, 1, U32, RW, 4), OWN(index, 2, U8, RW, 1)
#define TRANSMIT(index) RECEIVE(index), OWN(index, 3, U16, RW, 2), OWN(index, 5, U16, RW, 2)

extern const tumble_entry_t fixture_entries[];
extern const tumble_object_table_t fixture_table;

typedef struct {
    fake_port_t fake;
    variables_t variables;
    other_t other;
    tumble_node_t node;
    uint32_t computed;  /* 2010h */
    char sentence[65];  /* 2011h */
    unsigned writes;    /* calls of the write hook */
    unsigned resets[2]; /* communication, application */
    unsigned state_changes;
    unsigned heartbeats;    /* events of watched nodes */
    uint8_t heartbeat_node; /* of the last one */
    tumble_heartbeat_event_t heartbeat_event;
    tumble_nmt_state_t heartbeat_state;
    unsigned emergencies;
    uint8_t emergency_node;
    tumble_emergency_t emergency;
    unsigned pdos[TUMBLE_MAX_RECEIVE_PDOS];
} fixture_t;

extern fixture_t at;
extern const tumble_object_hooks_t fixture_hooks;
extern const tumble_node_events_t fixture_events;

tumble_abort_t fixture_read(void *context, const tumble_entry_t *entry, uint8_t *bytes, uint8_t *size);

/* Defaults without PDOs and without heartbeat, so that a test sees nothing but what it asks for. */
extern const tumble_node_defaults_t fixture_quiet;

tumble_status_t fixture_start(const tumble_node_defaults_t *defaults);

void step(void);

/* Let time go on and step. */
void pass(uint64_t us);

tumble_can_frame_t frame_of(uint16_t id, const char *text);

/* Hand the node a frame, without a step. */
bool hand(uint16_t id, const char *text);

/* Hand it over and let the node answer. */
void give(uint16_t id, const char *text);

void expect_at(uint16_t id, const char *text, int line);

#define expect(id, text) expect_at(id, text, __LINE__)
#define expect_nothing() TEST_ASSERT_EQUAL_UINT(0, at.fake.from_firmware.count)

/* What the next step sends. */
#define expect_next(id, text)                                                                                          \
    do {                                                                                                               \
        step();                                                                                                        \
        expect(id, text);                                                                                              \
    } while (0)
#define expect_no_next()                                                                                               \
    do {                                                                                                               \
        step();                                                                                                        \
        expect_nothing();                                                                                              \
    } while (0)

#define expect_after(us, id, text)                                                                                     \
    do {                                                                                                               \
        pass(us);                                                                                                      \
        expect(id, text);                                                                                              \
    } while (0)
#define expect_nothing_for(us)                                                                                         \
    do {                                                                                                               \
        pass(us);                                                                                                      \
        expect_nothing();                                                                                              \
    } while (0)

/* A frame, and the first one that comes of it. */
#define trade(id, text, sent_id, sent)                                                                                 \
    do {                                                                                                               \
        give(id, text);                                                                                                \
        expect(sent_id, sent);                                                                                         \
    } while (0)

/* One exchange with the SDO server. */
#define ask(request, answer)                                                                                           \
    do {                                                                                                               \
        trade(0x605, request, 0x585, answer);                                                                          \
        expect_nothing();                                                                                              \
    } while (0)

/* Up to Pre-operational, the boot-up message taken. */
void boot(void);

void boot_to_operational(void);

/* What the node has sent does not matter. */
void drain(void);

tumble_nmt_state_t state(void);

/* Before each case, and after: with no defaults; so, and booted; so, and Operational; with heartbeats both ways. */
void fixture_quietly(void);
void fixture_booted(void);
void fixture_operational(void);
void fixture_beating(void);
void fixture_end(void);

#endif
