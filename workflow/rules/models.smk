"""Section 3: equations, simulated impacts, calibrations and fits."""


use rule study as calibration with:
    """tables/calibration.csv, calibration_family.csv and molybdenum_capture.csv; data/ridge*.csv."""
    output:
        **tables("calibration", "calibration_family", "molybdenum_capture"),
        **data("ridge", "ridge_curves"),
    pathvars:
        study="calibration",
    params:
        **parameters("calibration"),


use rule study as inference with:
    """tables/evidence_*.csv, posterior_contacts.csv: the contact, by several laws and scenarios."""
    input:
        **tables("calibration"),
    output:
        **tables("evidence_summary", "evidence_statements", "posterior_contacts"),
        **data("evidence_limits", "evidence_works", "posterior_bands"),
    pathvars:
        study="inference",
    params:
        **parameters("inference"),


use rule study as size_law with:
    """tables/size_law_*.csv: v_c over the diameter by law, and rebounds that tell the laws apart."""
    input:
        **tables("calibration", "posterior_contacts"),
    output:
        **tables("size_law_exponents", "size_law_design"),
        **data("size_law_curves", "size_law_impacts"),
    pathvars:
        study="size_law",
    params:
        **parameters("size_law"),


use rule study as edge_speed with:
    """tables/edge_speed.csv: plateau, capture velocity and size by an edge that opens by its speed."""
    input:
        **tables("calibration"),
    output:
        **tables("edge_speed"),
        **data("edge_speed_plateau", "edge_speed_curves"),
    pathvars:
        study="edge_speed",
    params:
        **parameters("edge_speed"),


use rule study as restitution_trends with:
    """data/fig14.csv: R, rho and e against the impact speed (Eqs. 32-34)."""
    output:
        **data("fig14"),
    pathvars:
        study="restitution_trends",
    params:
        **parameters("restitution_trends"),


use rule study as coulomb_friction with:
    """data/fig17.csv: impulse ratio against angle for Coulomb friction (Eqs. 1-12)."""
    output:
        **data("fig17"),
    pathvars:
        study="coulomb_friction",
    params:
        **parameters("coulomb_friction"),


use rule study as oblique_impact with:
    """data/fig18.csv: impulse ratio, data/fig21.csv: energy loss."""
    input:
        **tables("calibration", "posterior_contacts", "oblique_experiments"),
    output:
        **data("fig18", "fig21"),
    pathvars:
        study="oblique_impact",
    params:
        **parameters("oblique_impact"),


use rule study as force_history with:
    """data/fig20.csv: normal force and its terms (Eq. 25), tables/force_ratios.csv: peaks of the normal force and of its terms."""
    input:
        **tables("calibration", "posterior_contacts"),
    output:
        **tables("force_ratios"),
        **data("fig20"),
    pathvars:
        study="force_history",
    params:
        **parameters("force_history"),


use rule study as contact_properties with:
    """tables/contact_properties.csv: stiffness, mass, forces and capture of every contact."""
    output:
        **tables("contact_properties"),
    pathvars:
        study="contact_properties",
    params:
        **parameters("contact_properties"),


use rule study as restitution_fits with:
    """data/fig15.csv, data/fig16.csv: simulated e and its fits; tables/restitution_fits.csv."""
    input:
        **tables("calibration"),
    output:
        **tables("restitution_fits"),
        **data("fig15", "fig16"),
    pathvars:
        study="restitution_fits",
    params:
        **parameters("restitution_fits"),


use rule study as fit_coverage with:
    """tables/fit_coverage.csv and others: how well the capture velocity is found and predicted."""
    input:
        **tables("calibration", "restitution_fits"),
    output:
        **tables("fit_coverage", "averaged_intervals", "capture_predictions"),
        **data("capture_recovery", "averaged_coverage"),
    pathvars:
        study="fit_coverage",
    params:
        **parameters("fit_coverage"),


use rule study as capture_velocities with:
    """tables/capture_laws.csv: v_c per pair and law, data/capture_law_curves.csv: over diameter."""
    input:
        **tables("calibration"),
    output:
        **tables("capture_laws"),
        **data("capture_law_curves"),
    pathvars:
        study="capture_velocities",
    params:
        **parameters("capture_velocities"),


use rule study as rolling_dissipation with:
    """tables/rolling_dissipation.csv: neglected moments; data/rolling.csv."""
    input:
        **tables("calibration"),
    output:
        **tables("rolling_dissipation"),
        **data("rolling"),
    pathvars:
        study="rolling_dissipation",
    params:
        **parameters("rolling_dissipation"),
