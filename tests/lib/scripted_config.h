/* scripted_config.h - a configuration of the navigation computer for the drive and the block that are played by
 * scripted_drive.h and scripted_block.h. Who takes it sets the averaging's pointer, and what is his own.
 */
#ifndef TUMBLE_TESTS_SCRIPTED_CONFIG_H
#define TUMBLE_TESTS_SCRIPTED_CONFIG_H

#include "scripted_block.h"
#include "scripted_drive.h"
#include "stand/drive402/drive402.h"
#include "tumble/navcomp.h"

extern const tumble_averaging_config_t scripted_averaging;
extern const tumble_procedure_config_t scripted_procedure;
extern const tumble_drive_profile_t scripted_drive_profile;
extern const tumble_navcomp_config_t scripted_navcomp;

#endif
