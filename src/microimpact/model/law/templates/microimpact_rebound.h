/* The rebound law of a contact, made by microimpact $version. C99, needs only <math.h>.
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

#define MICROIMPACT_SMALLEST $smallest        /* m: diameters between which it holds */
#define MICROIMPACT_LARGEST $largest
#define MICROIMPACT_DENSITY $density          /* kg/m3 */
#define MICROIMPACT_FRICTION $friction
#define MICROIMPACT_CAPTURES $captures        /* 0: nothing is captured */
#define MICROIMPACT_FASTEST $fastest          /* m/s */

#define MICROIMPACT_LOWEST ($lowest)
#define MICROIMPACT_SPLIT $split
#define MICROIMPACT_BANDS $bands
#define MICROIMPACT_PIECES $pieces
#define MICROIMPACT_WIDTHS $widths
#define MICROIMPACT_TERMS $terms

/* Over the size, Chebyshev coefficients of 1/unit of speed: that is the capture velocity, if any. */
static const double microimpact_slowness[$slownesses] = {$slowness};

/* Of bands of sizes and octaves of x = v/unit, less 1 where slow spheres are captured: polynomials in
 * size and speed, of e and of the supporting impulse over m v. */
static const double microimpact_table[MICROIMPACT_BANDS * MICROIMPACT_PIECES][MICROIMPACT_WIDTHS]
                                     [MICROIMPACT_TERMS][2] = {
    $coefficients
};

/* Position of a diameter (m) among the sizes, from -1 to 1. */
static inline double microimpact_position(double diameter)
{
    const double position = $narrowness * log(diameter / $diameter);
    return position < -1.0 ? -1.0 : position > 1.0 ? 1.0 : position;
}

/* A normal speed over the unit of speed of a position. */
static inline double microimpact_ratio(double speed, double position)
{
    double first = 0.0, second = 0.0, next;
    int k;

    for (k = $slownesses - 1; k > 0; k--) {
        next = 2.0 * position * first - second + microimpact_slowness[k];
        second = first;
        first = next;
    }
    return speed * (position * first - second + microimpact_slowness[0]);
}

/* Capture velocity of a diameter; 0: nothing is captured. */
static inline double microimpact_capture_velocity(double diameter)
{
    return MICROIMPACT_CAPTURES / microimpact_ratio(1.0, microimpact_position(diameter));
}

/* Coefficient of restitution, and impulse of the normal force in Coulomb's law ($basis) over m v, at
 * a diameter and a normal speed > 0. Returns 0: rebound; 1: captured; -1: not a speed of the table;
 * -2: not a size of the table. */
static inline int microimpact_normal(double diameter, double speed, double *restitution,
                                     double *impulse)
{
    const double lowest = ldexp(0.5, MICROIMPACT_LOWEST);
    double position, x, mantissa, place, t, s, e, i, closeness = 1.0;
    int exponent, part, piece, band, j, k;

    if (!(diameter >= MICROIMPACT_SMALLEST && diameter <= MICROIMPACT_LARGEST))
        return -2;
    if (!(speed > 0.0 && speed < MICROIMPACT_FASTEST))
        return -1;
    position = microimpact_position(diameter);
    x = microimpact_ratio(speed, position) - MICROIMPACT_CAPTURES;
    if (MICROIMPACT_CAPTURES && x <= 0.0) {
        *restitution = *impulse = 0.0;
        return 1;
    }
    if (MICROIMPACT_CAPTURES && x < lowest)
        closeness = sqrt(x / lowest);
    mantissa = frexp(x < lowest ? lowest : x, &exponent);
    place = (2.0 * mantissa - 1.0) * MICROIMPACT_SPLIT;
    part = (int)place;
    piece = (exponent - MICROIMPACT_LOWEST) * MICROIMPACT_SPLIT + part;
    if (piece >= MICROIMPACT_PIECES)
        return -1;
    t = 2.0 * (place - part) - 1.0;
    s = 0.5 * (position + 1.0) * MICROIMPACT_BANDS;
    band = s < MICROIMPACT_BANDS ? (int)s : MICROIMPACT_BANDS - 1;
    s = 2.0 * (s - band) - 1.0;
    *restitution = *impulse = 0.0;
    for (j = MICROIMPACT_WIDTHS - 1; j >= 0; j--) {
        const double (*terms)[2] = microimpact_table[band * MICROIMPACT_PIECES + piece][j];
        e = i = 0.0;
        for (k = MICROIMPACT_TERMS - 1; k >= 0; k--) {
            e = e * t + terms[k][0];
            i = i * t + terms[k][1];
        }
        *restitution = *restitution * s + e;
        *impulse = *impulse * s + i;
    }
    *restitution *= closeness;
    return 0;
}

/* Velocities and spin after an impact of a sphere. Returns 0: rebound; 1: captured, and it rolls on
 * with V_n = 0; -1: not approaching, or faster than the table; -2: smaller or larger than the sizes
 * of the table. Where negative, nothing is written. */
static inline int microimpact_rebound(double diameter, double v_n, double v_t, double omega,
                                      double *V_n, double *V_t, double *Omega)
{
    const double radius = 0.5 * diameter, slip = v_t - radius * omega;
    double e, impulse, available, change = fabs(slip) / $slip_per_impulse;
    const int captured = microimpact_normal(diameter, -v_n, &e, &impulse);

    if (captured < 0)
        return captured;
    available = MICROIMPACT_FRICTION * impulse * -v_n;
    if (!captured && available < change)
        change = $net ? MICROIMPACT_FRICTION * (1.0 + e) * -v_n : available;
    change = copysign(change, slip);
    *V_n = captured ? 0.0 : -e * v_n;
    *V_t = v_t - change;
    *Omega = omega + change / ($inertia * radius);
    return captured;
}

#endif
