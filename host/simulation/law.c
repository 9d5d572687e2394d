#include "simulation/law.h"

double sim_law_draw(sim_law_t law, double limit, sim_random_t *stream)
{
    switch (law) {
    case SIM_LAW_UNIFORM:
        return limit * sim_random_symmetric(stream);
    case SIM_LAW_SIGMA3:
        return limit / 3.0 * sim_random_normal(stream);
    default:
        return limit * sim_random_normal(stream);
    }
}
