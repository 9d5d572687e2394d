/* keeper_memory.h - the memory and the settings that a keeper begins with. */
#ifndef TUMBLE_TESTS_KEEPER_MEMORY_H
#define TUMBLE_TESTS_KEEPER_MEMORY_H

#include "flash.h"
#include "navcomp/keeper.h"
#include "support.h"

#define MEMORY_SECTOR 4096U

extern nv_memory_t memory;
extern tumble_keeper_t keeper;
extern tumble_sets_settings_t settings;
extern tumble_keeper_config_t keeper_config;

/* Blank. */
void memory_init(nv_memory_t *m);

tumble_sets_settings_t usual_settings(void);

#endif
