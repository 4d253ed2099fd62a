"""Section 3: equations, simulated impacts, calibrations and fits."""


use rule study as calibration with:
    """tables/calibration.csv, calibration_family.csv and molybdenum_capture.csv; data/ridge*.csv."""
    output:
        **tables("calibration", "calibration_family", "molybdenum_capture"),
        **data("ridge", "ridge_curves"),
    pathvars:
        name="calibration",
    params:
        **of("calibration"),


use rule study as admissible_contacts with:
    """tables/admissible_*.csv: contacts that the printed statements admit, and how they were drawn."""
    input:
        **needs("admissible_contacts"),
    output:
        **tables(
            "admissible_contacts",
            "admissible_diagnostics",
            "admissible_summary",
            "admissible_statements",
        ),
        **data(
            "admissible_limits",
            "admissible_shares",
            "admissible_works",
            "admissible_bands",
        ),
    pathvars:
        name="admissible_contacts",
    params:
        **of("admissible_contacts"),


use rule study as restitution_trends with:
    """data/fig14.csv: R, rho and e against the impact speed (Eqs. 32-34)."""
    output:
        **data("fig14"),
    pathvars:
        name="restitution_trends",
    params:
        **of("restitution_trends"),


use rule study as coulomb_friction with:
    """data/fig17.csv: impulse ratio against angle for Coulomb friction (Eqs. 1-12)."""
    output:
        **data("fig17"),
    pathvars:
        name="coulomb_friction",
    params:
        **of("coulomb_friction"),


use rule study as oblique_impact with:
    """data/fig18.csv: impulse ratio, data/fig21.csv: energy loss."""
    input:
        **needs("oblique_impact"),
    output:
        **data("fig18", "fig21"),
    pathvars:
        name="oblique_impact",
    params:
        **of("oblique_impact"),


use rule study as force_history with:
    """data/fig20.csv: normal force and its terms (Eq. 25), tables/force_ratios.csv: peaks of the normal force and of its terms."""
    input:
        **needs("force_history"),
    output:
        **tables("force_ratios"),
        **data("fig20"),
    pathvars:
        name="force_history",
    params:
        **of("force_history"),


use rule study as contact_properties with:
    """tables/contact_properties.csv: stiffness, mass, forces and capture of every contact."""
    output:
        **tables("contact_properties"),
    pathvars:
        name="contact_properties",
    params:
        **of("contact_properties"),


use rule study as restitution_fits with:
    """data/fig15.csv, data/fig16.csv: simulated e and its fits; tables/restitution_fits.csv."""
    input:
        **needs("restitution_fits"),
    output:
        **tables("restitution_fits"),
        **data("fig15", "fig16"),
    pathvars:
        name="restitution_fits",
    params:
        **of("restitution_fits"),


use rule study_part as fit_coverage_part with:
    input:
        **needs("fit_coverage"),
    pathvars:
        name="fit_coverage",
    params:
        **of("fit_coverage"),


use rule study as fit_coverage with:
    """tables/fit_*.csv, averaged_intervals.csv: how well the capture velocity is found."""
    input:
        **needs("fit_coverage"),
        parts=parts("fit_coverage"),
    output:
        **tables("fit_coverage", "fit_intervals", "averaged_intervals"),
        **data("capture_recovery", "averaged_coverage"),
    pathvars:
        name="fit_coverage",
    params:
        **of("fit_coverage"),


use rule study as capture_velocities with:
    """tables/capture_laws.csv: v_c per pair and law, data/capture_law_curves.csv: over diameter."""
    input:
        **needs("capture_velocities"),
    output:
        **tables("capture_laws"),
        **data("capture_law_curves"),
    pathvars:
        name="capture_velocities",
    params:
        **of("capture_velocities"),


use rule study as contact_laws with:
    """tables/contact_law_*.csv: fits, facts, claims by law; data/contact_law_curves.csv: e(v)."""
    input:
        **needs("contact_laws"),
    output:
        **tables("contact_law_fits", "contact_law_facts", "contact_law_claims"),
        **data("contact_law_curves"),
    pathvars:
        name="contact_laws",
    params:
        **of("contact_laws"),


use rule study as rolling_dissipation with:
    """tables/rolling_dissipation.csv, rolling_ranges.csv: neglected moments; data/rolling.csv."""
    input:
        **needs("rolling_dissipation"),
    output:
        **tables("rolling_dissipation", "rolling_ranges"),
        **data("rolling"),
    pathvars:
        name="rolling_dissipation",
    params:
        **of("rolling_dissipation"),
