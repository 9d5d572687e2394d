/* law.h - what a declared error limit means, and one draw of such an error. */
#ifndef TUMBLE_SIMULATION_LAW_H
#define TUMBLE_SIMULATION_LAW_H

#include "simulation/random.h"

typedef enum {
    SIM_LAW_SIGMA1 = 0, /* the limit is a standard deviation of a normal law */
    SIM_LAW_SIGMA3,     /* three of them */
    SIM_LAW_UNIFORM     /* half the width of a uniform law */
} sim_law_t;

/* One error of a source with this limit; 0 for a limit of 0. One draw from the stream in either case. */
double sim_law_draw(sim_law_t law, double limit, sim_random_t *stream);

#endif
