"""Section 4: rough surfaces, Monte Carlo, designs and indices; tables of inputs; other data."""


use rule study as declared_inputs with:
    """tables/inputs.csv: every declared number with unit, evidence class and source."""
    output:
        **tables("inputs"),
    pathvars:
        study="declared_inputs",
    params:
        **parameters("declared_inputs"),


use rule study as roughness_expansions with:
    """data/roughness.csv: Eqs. 35-41, exact, as printed and corrected."""
    output:
        **data("roughness"),
    pathvars:
        study="roughness_expansions",
    params:
        **parameters("roughness_expansions"),


# Another number of parts, each a job: `snakemake --set-scatter monte_carlo=64`.
scattergather:
    monte_carlo=1,


MONTE_CARLO_PARTS = gather.monte_carlo("<results>/parts/monte_carlo-{scatteritem}.csv")


rule monte_carlo_part:
    """parts/*.csv: estimates of some of the variants and angles, until all are gathered."""
    input:
        **tables("calibration"),
        samples=sample_files(SETTINGS.branches["monte_carlo"]),
    output:
        part=temp("<results>/parts/monte_carlo-{scatteritem}.csv"),
    log:
        "<results>/logs/monte_carlo-{scatteritem}.log",
    benchmark:
        "<results>/benchmarks/monte_carlo-{scatteritem}.tsv"
    params:
        **parameters("monte_carlo"),
    script:
        "../scripts/run_study.py"


use rule study as monte_carlo with:
    """data/fig23.csv; tables/monte_carlo.csv, slope_inference.csv."""
    input:
        **tables("calibration"),
        samples=sample_files(SETTINGS.branches["monte_carlo"]),
        # A single part is made at once.
        parts=MONTE_CARLO_PARTS[1:] and MONTE_CARLO_PARTS,
    output:
        **tables("monte_carlo", "slope_inference"),
        **data("fig23"),
    pathvars:
        study="monte_carlo",
    params:
        **parameters("monte_carlo"),


use rule study as doe with:
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
        study="doe",
    params:
        **parameters("doe"),


use rule study as sensitivity with:
    """data/sobol.csv: indices drawn; tables/sensitivity_*.csv: indices, groups, convergence."""
    input:
        **tables("calibration", "calibration_family", "doe_levels", "doe_effects"),
    output:
        **tables("sensitivity_indices", "sensitivity_convergence", "sensitivity_groups"),
        **data("sobol"),
    pathvars:
        study="sensitivity",
    params:
        **parameters("sensitivity"),


use rule study as particle_separation with:
    """data/separation.csv: forces against silica, tables/particle_separation.csv: what holds."""
    output:
        **tables("particle_separation"),
        **data("separation"),
    pathvars:
        study="particle_separation",
    params:
        **parameters("particle_separation"),


use rule study as oblique_data with:
    """tables/oblique_*.csv: measured oblique impacts against the laws."""
    input:
        **tables("calibration"),
    output:
        **tables("oblique_comparison", "oblique_residuals"),
        **data("oblique_velocity", "oblique_spin", "contact_point"),
    pathvars:
        study="oblique_data",
    params:
        **parameters("oblique_data"),


use rule study as external_evidence with:
    """tables/external_evidence.csv: facts that others found beside what the model gives."""
    input:
        **tables("calibration", "doe_levels", "doe_effects", "monte_carlo", "oblique_residuals"),
    output:
        **tables("external_evidence"),
    pathvars:
        study="external_evidence",
    params:
        **parameters("external_evidence"),
