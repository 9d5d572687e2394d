/* store_power.h - power cuts and lying memory at every operation of every job, once and twice. Needs no Unity.
 *
 * A scenario brings the memory into a state, has a job, and says which states may be found after it was disturbed. For
 * every operation and every way to go wrong: run, power on again, look, do the job again (there may be a second fault),
 * power on again, look, and then do it undisturbed, which must succeed.
 */
#ifndef STORE_POWER_H
#define STORE_POWER_H

#include "flash.h"

typedef enum { STATE_BAD, STATE_BEFORE, STATE_BETWEEN, STATE_AFTER } state_t;

/* What a memory holds before the job, as far as the preparation knows of it. */
typedef struct {
    unsigned factory; /* sets: of the factory, committed, rolled back, held */
    unsigned commits;
    unsigned rollbacks;
    unsigned held;
    uint32_t entries; /* of a log */
    uint32_t run;     /* whose log it is */
} start_t;

typedef struct {
    const char *name;
    void (*prepare)(nv_memory_t *memory, const start_t *start); /* on an erased memory */
    bool (*boot)(nv_memory_t *memory);                          /* a new object; false: it never ends */
    tumble_status_t (*job)(void);                               /* begin, and step to the end */
    state_t (*look)(void);                                      /* by what the object answers */
    start_t start;
} scenario_t;

typedef struct {
    unsigned long cases;
    unsigned long bad;
    const char *scenario;
    uint32_t granule;
    uint32_t sector;
    uint32_t sectors;
    nv_fault_t faults[NV_FAULTS];
    char first[200]; /* the first bad case */
} campaign_t;

typedef struct {
    const done_t *done;
    unsigned done_count;
} fault_list_t;

/* Every operation, every kind; `twice`: and after each the same again. */
void power_scenario(campaign_t *campaign, const scenario_t *scenario, const fault_list_t *list, bool twice);

#endif
