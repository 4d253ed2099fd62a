"""A rule per analysis, under its name: the tables of others that it reads, and those that it makes."""


rule analysis:
    """No file: the script, log and costs of all analyses."""
    log:
        "<results>/logs/<analysis>.log",
    benchmark:
        "<results>/benchmarks/<analysis>.tsv"
    pathvars:
        analysis="analysis",
    script:
        "../scripts/run_analysis.py"


use rule analysis as fig01_03_13_19_22_schematics with:
    """data/fig01.csv ... fig22.csv: Figs. 1, 2, 3, 13, 19, 22."""
    input:
        **tables("calibration"),
    output:
        **data(
            "fig01",
            "fig02",
            "fig03",
            "fig13",
            "fig19",
            "fig19_pressure",
            "fig19_ring",
            "fig22",
        ),
    pathvars:
        analysis="fig01_03_13_19_22_schematics",
    params:
        **parameters("fig01_03_13_19_22_schematics"),


use rule analysis as fig04_05_normal_experiments with:
    """data/fig04.csv, data/fig05.csv: normal impacts seen by the PDPA; tables of the same."""
    input:
        **tables("calibration"),
    output:
        **tables("normal_experiments", "size_effects"),
        **data("fig04", "fig05"),
    pathvars:
        analysis="fig04_05_normal_experiments",
    params:
        **parameters("fig04_05_normal_experiments"),


use rule analysis as fig06_12_oblique_experiments with:
    """data/fig06.csv to fig12.csv: oblique impacts seen by the PTIS; table of the experiments."""
    input:
        **tables("calibration"),
    output:
        **tables("oblique_experiments"),
        **data("fig06", "fig07", "fig08", "fig09", "fig10", "fig11", "fig12"),
        **data("fig23_points"),
    pathvars:
        analysis="fig06_12_oblique_experiments",
    params:
        **parameters("fig06_12_oblique_experiments"),


use rule analysis as fig14_restitution_trends with:
    """data/fig14.csv: R, rho and e against the impact speed (Eqs. 32-34)."""
    output:
        **data("fig14"),
    pathvars:
        analysis="fig14_restitution_trends",
    params:
        **parameters("fig14_restitution_trends"),


use rule analysis as fig15_16_restitution_fits with:
    """data/fig15.csv, data/fig16.csv: simulated e and its fits; tables/restitution_fits.csv."""
    input:
        **tables("calibration"),
    output:
        **tables("restitution_fits"),
        **data("fig15", "fig16"),
    pathvars:
        analysis="fig15_16_restitution_fits",
    params:
        **parameters("fig15_16_restitution_fits"),


use rule analysis as fig17_coulomb_friction with:
    """data/fig17.csv: impulse ratio against angle for Coulomb friction (Eqs. 1-12)."""
    output:
        **data("fig17"),
    pathvars:
        analysis="fig17_coulomb_friction",
    params:
        **parameters("fig17_coulomb_friction"),


use rule analysis as fig18_21_oblique_impact with:
    """data/fig18.csv: impulse ratio, data/fig21.csv: energy loss."""
    input:
        **tables("calibration", "posterior_contacts", "oblique_experiments"),
    output:
        **data("fig18", "fig21"),
    pathvars:
        analysis="fig18_21_oblique_impact",
    params:
        **parameters("fig18_21_oblique_impact"),


use rule analysis as fig20_force_history with:
    """data/fig20.csv: normal force and its terms (Eq. 25), tables/force_ratios.csv: peaks of the normal force and of its terms."""
    input:
        **tables("calibration"),
    output:
        **tables("force_ratios"),
        **data("fig20"),
    pathvars:
        analysis="fig20_force_history",
    params:
        **parameters("fig20_force_history"),


# Another number of parts, each a job: `snakemake --set-scatter fig23_monte_carlo=64`.
scattergather:
    fig23_monte_carlo=1,


MONTE_CARLO_PARTS = gather.fig23_monte_carlo("<results>/parts/fig23_monte_carlo-{scatteritem}.csv")


rule fig23_monte_carlo_part:
    """parts/*.csv: estimates of some of the variants and angles, until all are gathered."""
    input:
        **tables("calibration"),
        samples=sample_files(SETTINGS.branches["fig23_monte_carlo"]),
    output:
        part=temp("<results>/parts/fig23_monte_carlo-{scatteritem}.csv"),
    log:
        "<results>/logs/fig23_monte_carlo-{scatteritem}.log",
    benchmark:
        "<results>/benchmarks/fig23_monte_carlo-{scatteritem}.tsv"
    params:
        **parameters("fig23_monte_carlo"),
    script:
        "../scripts/run_analysis.py"


use rule analysis as fig23_monte_carlo with:
    """data/fig23.csv; tables/monte_carlo.csv, slope_inference.csv."""
    input:
        **tables("calibration"),
        samples=sample_files(SETTINGS.branches["fig23_monte_carlo"]),
        # A single part is made at once.
        parts=MONTE_CARLO_PARTS[1:] and MONTE_CARLO_PARTS,
    output:
        **tables("monte_carlo", "slope_inference"),
        **data("fig23"),
    pathvars:
        analysis="fig23_monte_carlo",
    params:
        **parameters("fig23_monte_carlo"),


use rule analysis as fig24_25_doe with:
    """data/fig24.csv, data/fig25.csv: effects drawn; tables/doe_*.csv: designs and their analysis."""
    input:
        **tables("calibration", "calibration_family"),
    output:
        **tables(
            "doe_levels",
            "doe_design",
            "doe_effects",
            "doe_bd_aliasing",
            "doe_elasticities",
        ),
        **data("fig24", "fig25"),
    pathvars:
        analysis="fig24_25_doe",
    params:
        **parameters("fig24_25_doe"),


use rule analysis as calibration with:
    """tables/calibration.csv, calibration_family.csv and molybdenum_capture.csv; data/ridge*.csv."""
    output:
        **tables("calibration", "calibration_family", "molybdenum_capture"),
        **data("ridge", "ridge_curves"),
    pathvars:
        analysis="calibration",
    params:
        **parameters("calibration"),


use rule analysis as campaign with:
    """tables/campaign.csv: all 187 experiments; data of campaign_map."""
    input:
        **tables("calibration"),
    output:
        **tables("campaign"),
        **data("campaign_map"),
    pathvars:
        analysis="campaign",
    params:
        **parameters("campaign"),


use rule analysis as capture_velocities with:
    """tables/capture_laws.csv: v_c per pair and law, data/capture_law_curves.csv: over diameter."""
    input:
        **tables("calibration"),
    output:
        **tables("capture_laws"),
        **data("capture_law_curves"),
    pathvars:
        analysis="capture_velocities",
    params:
        **parameters("capture_velocities"),


use rule analysis as contact_properties with:
    """tables/contact_properties.csv: stiffness, mass, forces and capture of every contact."""
    output:
        **tables("contact_properties"),
    pathvars:
        analysis="contact_properties",
    params:
        **parameters("contact_properties"),


use rule analysis as declared_inputs with:
    """tables/inputs.csv: every declared number with unit, evidence class and source."""
    output:
        **tables("inputs"),
    pathvars:
        analysis="declared_inputs",
    params:
        **parameters("declared_inputs"),


use rule analysis as edge_speed with:
    """tables/edge_speed.csv: plateau, capture velocity and size by an edge that opens by its speed."""
    input:
        **tables("calibration"),
    output:
        **tables("edge_speed"),
        **data("edge_speed_plateau", "edge_speed_curves"),
    pathvars:
        analysis="edge_speed",
    params:
        **parameters("edge_speed"),


use rule analysis as external_evidence with:
    """tables/external_evidence.csv: facts that others found beside what the model gives."""
    input:
        **tables("calibration", "doe_levels", "doe_effects", "monte_carlo", "oblique_residuals"),
    output:
        **tables("external_evidence"),
    pathvars:
        analysis="external_evidence",
    params:
        **parameters("external_evidence"),


use rule analysis as inference with:
    """tables/evidence_*.csv, posterior_contacts.csv: the contact, by several laws and scenarios."""
    input:
        **tables("calibration"),
    output:
        **tables("evidence_summary", "evidence_statements", "posterior_contacts"),
        **data(
            "evidence_limits",
            "evidence_works",
            "capture_velocity_summary",
            "capture_velocity_profile",
            "posterior_bands",
        ),
    pathvars:
        analysis="inference",
    params:
        **parameters("inference"),


use rule analysis as interval_coverage with:
    """tables/interval_coverage.csv: how often 95 % intervals hold each mean; figure data."""
    input:
        **tables("calibration"),
    output:
        **tables("interval_coverage"),
        **data("coverage_by_speed", "coverage_by_angle"),
    pathvars:
        analysis="interval_coverage",
    params:
        **parameters("interval_coverage"),


use rule analysis as mechanisms with:
    """Tables of spin, slope, spore, adhesion and speed mechanisms; data of the figure causes."""
    input:
        **tables("calibration"),
    output:
        **tables(
            "spin_mechanism",
            "spin_needed",
            "spin_or_tilt",
            "slope_mechanism",
            "surface_pairs",
            "formica_mechanism",
            "spore_mechanism",
            "spore_trends",
            "spore_comparison",
            "smooth_spore",
            "adhesion_or_roughness",
            "loss_slopes",
            "loss_resolution",
        ),
        **data("causes", "causes_slope", "causes_shallow"),
    pathvars:
        analysis="mechanisms",
    params:
        **parameters("mechanisms"),


use rule analysis as oblique_data with:
    """tables/oblique_*.csv: measured oblique impacts against the laws."""
    input:
        **tables("calibration"),
    output:
        **tables("oblique_comparison", "oblique_residuals"),
        **data("oblique_velocity", "oblique_spin", "contact_point"),
    pathvars:
        analysis="oblique_data",
    params:
        **parameters("oblique_data"),


use rule analysis as pair_search with:
    """tables/pairing_quality.csv, surface_correction.csv; data of doppler_pairs."""
    input:
        **tables("calibration"),
    output:
        **tables("pairing_quality", "surface_correction"),
        **data("doppler_stream", "pairing_curves", "correction_curves"),
    pathvars:
        analysis="pair_search",
    params:
        **parameters("pair_search"),


use rule analysis as particle_separation with:
    """data/separation.csv: forces against silica, tables/particle_separation.csv: what holds."""
    output:
        **tables("particle_separation"),
        **data("separation"),
    pathvars:
        analysis="particle_separation",
    params:
        **parameters("particle_separation"),


use rule analysis as pile_up with:
    """data/pile_up_onset.csv: spheres that end on the target; tables of shares and onsets."""
    input:
        **tables("calibration", "evidence_summary"),
    output:
        **tables("pile_up", "pile_up_onsets"),
        **data("pile_up_onset"),
    pathvars:
        analysis="pile_up",
    params:
        **parameters("pile_up"),


use rule analysis as rival_explanations with:
    """data/rival_restitution.csv; tables: what adhesion, a probe above the surface and v_c give."""
    input:
        **tables("calibration", "pile_up", "pile_up_onsets"),
    output:
        **tables("rival_explanations", "capture_evidence", "rival_forces"),
        **data("rival_restitution"),
    pathvars:
        analysis="rival_explanations",
    params:
        **parameters("rival_explanations"),


use rule analysis as rolling_dissipation with:
    """tables/rolling_dissipation.csv: neglected moments; data/rolling.csv."""
    input:
        **tables("calibration"),
    output:
        **tables("rolling_dissipation"),
        **data("rolling"),
    pathvars:
        analysis="rolling_dissipation",
    params:
        **parameters("rolling_dissipation"),


use rule analysis as roughness_expansions with:
    """data/roughness.csv: Eqs. 35-41, exact, as printed and corrected."""
    output:
        **data("roughness"),
    pathvars:
        analysis="roughness_expansions",
    params:
        **parameters("roughness_expansions"),


use rule analysis as sensitivity with:
    """data/sobol.csv: indices drawn; tables/sensitivity_*.csv: indices, convergence."""
    input:
        **tables("calibration", "doe_levels", "doe_effects"),
    output:
        **tables("sensitivity_indices", "sensitivity_convergence"),
        **data("sobol"),
    pathvars:
        analysis="sensitivity",
    params:
        **parameters("sensitivity"),


use rule analysis as size_law with:
    """tables/size_law_*.csv: v_c over the diameter by law, and rebounds that tell the laws apart."""
    input:
        **tables("calibration", "posterior_contacts"),
    output:
        **tables("size_law_exponents", "size_law_design"),
        **data("size_law_curves", "size_law_impacts"),
    pathvars:
        analysis="size_law",
    params:
        **parameters("size_law"),


use rule analysis as track_imaging with:
    """tables/ptis_range.csv: range and errors of the imaging; data of ptis_frame, ptis_accuracy."""
    output:
        **tables("ptis_range"),
        **data("ptis_frame", "ptis_pixels", "ptis_accuracy"),
    pathvars:
        analysis="track_imaging",
    params:
        **parameters("track_imaging"),
