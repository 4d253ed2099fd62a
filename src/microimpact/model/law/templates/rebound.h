/* The rebound law of one contact, made by microimpact $version. C99, needs only <math.h>.
 *
 * $described
 *
 * Signs: v_n < 0 approaches the surface; v_t is along the surface; omega > 0 is the sense in which
 * the sphere would roll along +t, so that the slip of the contact point is v_t - r omega.
 * SI units: m/s, rad/s. The law knows the speed of approach along the normal, not the total speed.
 */
#ifndef MICROIMPACT_REBOUND_H
#define MICROIMPACT_REBOUND_H

#include <math.h>

#define MICROIMPACT_RADIUS $radius            /* m */
#define MICROIMPACT_DIAMETER $diameter        /* m */
#define MICROIMPACT_DENSITY $density          /* kg/m3 */
#define MICROIMPACT_FRICTION $friction
#define MICROIMPACT_CAPTURE_VELOCITY $capture_velocity /* m/s; 0: nothing is captured */
#define MICROIMPACT_FASTEST $fastest          /* m/s */

#define MICROIMPACT_LOWEST ($lowest)
#define MICROIMPACT_SPLIT $split
#define MICROIMPACT_PIECES $pieces
#define MICROIMPACT_TERMS $terms

/* Of octaves of x = v/unit - offset, polynomials of e and of the supporting impulse over m v. */
static const double microimpact_table[MICROIMPACT_PIECES][MICROIMPACT_TERMS][2] = {
    $coefficients
};

/* Coefficient of restitution, and impulse of the normal force in Coulomb's law ($basis) over m v, at
 * a normal speed > 0. Returns 0: rebound; 1: captured; -1: not a speed of the table. */
static inline int microimpact_normal(double speed, double *restitution, double *impulse)
{
    const double lowest = ldexp(0.5, MICROIMPACT_LOWEST), x = speed / $unit - $offset;
    double mantissa, place, t, e, i, closeness = 1.0;
    int exponent, part, piece, k;

    if (!(speed > 0.0 && speed < MICROIMPACT_FASTEST))
        return -1;
    if (speed <= MICROIMPACT_CAPTURE_VELOCITY) {
        *restitution = *impulse = 0.0;
        return 1;
    }
    if (x < lowest && $offset > 0.0)
        closeness = x > 0.0 ? sqrt(x / lowest) : 0.0;
    mantissa = frexp(x < lowest ? lowest : x, &exponent);
    place = (2.0 * mantissa - 1.0) * MICROIMPACT_SPLIT;
    part = (int)place;
    piece = (exponent - MICROIMPACT_LOWEST) * MICROIMPACT_SPLIT + part;
    if (piece >= MICROIMPACT_PIECES)
        return -1;
    t = 2.0 * (place - part) - 1.0;
    e = microimpact_table[piece][MICROIMPACT_TERMS - 1][0];
    i = microimpact_table[piece][MICROIMPACT_TERMS - 1][1];
    for (k = MICROIMPACT_TERMS - 2; k >= 0; k--) {
        e = e * t + microimpact_table[piece][k][0];
        i = i * t + microimpact_table[piece][k][1];
    }
    *restitution = closeness * e;
    *impulse = i;
    return 0;
}

/* Velocities and spin after an impact. Returns 0: rebound; 1: captured, and it rolls on with
 * V_n = 0; -1: not approaching, or faster than the table, and nothing is written. */
static inline int microimpact_rebound(double v_n, double v_t, double omega, double *V_n,
                                      double *V_t, double *Omega)
{
    const double slip = v_t - MICROIMPACT_RADIUS * omega;
    double e, impulse, available, change = fabs(slip) / $slip_per_impulse;
    const int captured = microimpact_normal(-v_n, &e, &impulse);

    if (captured < 0)
        return captured;
    available = MICROIMPACT_FRICTION * impulse * -v_n;
    if (!captured && available < change)
        change = $net ? MICROIMPACT_FRICTION * (1.0 + e) * -v_n : available;
    change = copysign(change, slip);
    *V_n = captured ? 0.0 : -e * v_n;
    *V_t = v_t - change;
    *Omega = omega + change / ($inertia * MICROIMPACT_RADIUS);
    return captured;
}

#endif
