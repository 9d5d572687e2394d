/* turn.h - a small turn of an angle or a vector, without libm (private to the core). */
#ifndef TUMBLE_CORE_TURN_H
#define TUMBLE_CORE_TURN_H

/* Turn the angle that has this sine and cosine further by a small x, to TUMBLE_MAX_STAND_ERROR_RAD: likewise two
 * components (a, b) of a vector to (a cos x + b sin x, b cos x - a sin x). */
void tumble_turn(double x, double *sine, double *cosine);

#endif
