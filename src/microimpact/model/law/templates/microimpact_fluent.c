/* A wall of Fluent's discrete phase with the rebound law of microimpact $version.
 *
 * $described
 *
 * Compile it with the header beside it, and choose microimpact_wall as boundary condition of the
 * discrete phase at the wall. The path of a particle of another diameter, by more than 1 %, is aborted
 * with a message; spin is taken as zero, since the tracked particle carries none by default.
 */
#include "udf.h"

#include "microimpact_rebound.h"

DEFINE_DPM_BC(microimpact_wall, particle, thread, face, normal, dim)
{
    real v_n = 0.0, v_t = 0.0, tangential[3] = {0.0, 0.0, 0.0};
    double after_n, after_t, after_spin;
    int i, captured;
    static int warned = 0;

    (void)thread;
    (void)face;
    if (fabs(TP_DIAM(particle) - MICROIMPACT_DIAMETER) > 0.01 * MICROIMPACT_DIAMETER) {
        if (!warned)
            Message("microimpact: a particle of %g m meets the rebound law of %g m; its path, and that "
                    "of all of other sizes, is aborted\n", TP_DIAM(particle), MICROIMPACT_DIAMETER);
        warned = 1;
        return PATH_ABORT;
    }
    /* The normal of the face points out of the fluid: a particle that arrives has v_n > 0. */
    for (i = 0; i < dim; i++)
        v_n += TP_VEL(particle)[i] * normal[i];
    for (i = 0; i < dim; i++) {
        tangential[i] = TP_VEL(particle)[i] - v_n * normal[i];
        v_t += tangential[i] * tangential[i];
    }
    v_t = sqrt(v_t);
    captured = microimpact_rebound(-v_n, v_t, 0.0, &after_n, &after_t, &after_spin);
    if (captured != 0)
        return captured > 0 ? PATH_END : PATH_ABORT;
    for (i = 0; i < dim; i++) {
        TP_VEL(particle)[i] = (v_t > 0.0 ? after_t / v_t * tangential[i] : 0.0) - after_n * normal[i];
        TP_VEL0(particle)[i] = TP_VEL(particle)[i];
    }
    return PATH_ACTIVE;
}
