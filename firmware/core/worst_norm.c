#include "tumble/core.h"

#include "core/arith.h"
#include "core/vector.h"

/* u(|a|)^2 is a polynomial of degree four in the attitude. The grid is the faces, edges and corners of a cube; every
 * hump of such a polynomial has one of its attitudes on its slope, so a climb from the best of them finds the top. */
#define GRID 27U /* the cube with its middle, which is no attitude */
#define MIDDLE 13U
#define AROUND 6U /* neighbours that are tried in a round */
#define FIRST_STEP 0.4
#define HALVINGS 4U /* the last step is 0.05: it leaves a percent of u */
#define MOST_ROUNDS 20U

void tumble_worst_norm_begin(tumble_worst_norm_t *search)
{
    *search = (tumble_worst_norm_t){0};
}

void tumble_worst_norm_attitude(const tumble_worst_norm_t *search, double attitude[3])
{
    uint32_t digits = search->place;
    const uint32_t way = search->place - GRID; /* beyond the grid */
    const double step = FIRST_STEP / (double)(UINT32_C(1) << search->halvings);
    for (uint32_t i = 0; i < 3U; i++) {
        attitude[i] = (double)((int32_t)(digits % 3U) - 1);
        digits /= 3U;
        if (search->place >= GRID) {
            const double away = ((way & 1U) != 0U) ? step : -step;
            attitude[i] = search->best[i] + (((way / 2U) == i) ? away : 0.0);
        }
    }
    const double length = tumble_sqrt(tumble_dot(attitude, attitude));
    for (int i = 0; i < 3; i++) {
        attitude[i] /= length;
    }
}

/* Six neighbours have been tried, each of the best at its time. */
static void end_round(tumble_worst_norm_t *search)
{
    search->halvings = (uint8_t)(search->halvings + (search->rises ? 0U : 1U));
    search->rises = false;
    search->place = (uint8_t)GRID;
    search->rounds++;
}

bool tumble_worst_norm_next(tumble_worst_norm_t *search, double u_g)
{
    if (tumble_exceeds(u_g, search->worst_g)) {
        double attitude[3];
        tumble_worst_norm_attitude(search, attitude);
        search->worst_g = u_g;
        search->rises = (search->place >= GRID);
        for (int i = 0; i < 3; i++) {
            search->best[i] = attitude[i];
        }
    }
    search->place = (uint8_t)(search->place + ((search->place == (MIDDLE - 1U)) ? 2U : 1U));
    if (search->place == (GRID + AROUND)) {
        end_round(search);
    }
    return (search->halvings < HALVINGS) && (search->rounds < MOST_ROUNDS);
}
