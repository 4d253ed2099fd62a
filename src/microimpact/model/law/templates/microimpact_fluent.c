/* A wall of Fluent's discrete phase with the rebound law of microimpact $version.
 *
 * $described
 *
 * Compile it with the header beside it, and choose microimpact_wall as boundary condition of the
 * discrete phase at the wall. The path of a particle whose size or speed the law does not hold for is
 * aborted with a message; spin is taken as zero, since the tracked particle carries none by default.
 * With a user-defined memory allocated, the first sums the mass that is captured beside each wall: in
 * kg where particles are tracked in time, in kg/s where they are not. Axisymmetric swirl and moving
 * walls are refused: there the paths are aborted, too. Tried against a stub, not in Fluent.
 */
#include "udf.h"

#include "microimpact_rebound.h"

DEFINE_DPM_BC(microimpact_wall, particle, thread, face, normal, dim)
{
    real v_n = 0.0, v_t = 0.0, tangential[3] = {0.0, 0.0, 0.0};
    double after_n, after_t, after_spin;
    int i, outcome, moving;
    static int warned = 0;

    (void)face;
    moving = SV_ALLOCATED_P(thread, SV_WALL_GRID_V) && SV_ALLOCATED_P(thread, SV_WALL_V);
    if (rp_axi_swirl || moving) {
        if (!warned)
            Message("microimpact: not for %s; all paths that meet a wall are aborted\n",
                    moving ? "moving walls" : "axisymmetric swirl");
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
    outcome = microimpact_rebound(TP_DIAM(particle), -v_n, v_t, 0.0, &after_n, &after_t, &after_spin);
    if (outcome < 0) {
        if (!warned)
            Message("microimpact: the rebound law does not hold for a particle of %g m at %g m/s along "
                    "the normal; its path is aborted, and so are all such\n", TP_DIAM(particle), v_n);
        warned = 1;
        return PATH_ABORT;
    }
    if (outcome == 1) {
        if (N_UDM > 0)
            C_UDMI(TP_CELL(particle), TP_CELL_THREAD(particle), 0) +=
                dpm_par.unsteady_tracking ? TP_N(particle) * TP_MASS(particle) : TP_FLOW_RATE(particle);
        return PATH_END;
    }
    for (i = 0; i < dim; i++) {
        TP_VEL(particle)[i] = (v_t > 0.0 ? after_t / v_t * tangential[i] : 0.0) - after_n * normal[i];
        TP_VEL0(particle)[i] = TP_VEL(particle)[i];
    }
    return PATH_ACTIVE;
}
