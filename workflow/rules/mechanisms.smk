"""Supposed mechanisms, each alone; piles on the target; what the laboratory's spreads do."""


rule mechanisms:
    """Tables of spin, slope, spore, adhesion and speed mechanisms; data of the figure causes."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        **{
            table: f"<results>/tables/{table}.csv"
            for table in (
                "spin_mechanism",
                "spin_needed",
                "rolling_limits",
                "spin_or_tilt",
                "slope_mechanism",
                "surface_pairs",
                "slope_needed",
                "formica_mechanism",
                "spore_mechanism",
                "spore_trends",
                "spore_comparison",
                "smooth_spore",
                "adhesion_or_roughness",
                "speed_and_angle",
                "impulse_regions",
                "loss_slopes",
                "loss_resolution",
            )
        },
        causes="<results>/data/causes.csv",
        causes_slope="<results>/data/causes_slope.csv",
        causes_shallow="<results>/data/causes_shallow.csv",
    log:
        "<results>/logs/mechanisms.log",
        benchmark="<results>/benchmarks/mechanisms.tsv",
    params:
        branch=SETTINGS.branches["mechanisms"],
        rows=ROWS["mechanisms"],
        code=study_code("mechanisms"),
    script:
        "../scripts/run_study.py"


rule pile_up:
    """data/pile_up_onset.csv: spheres that end on the target; tables of shares and onsets."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        pile_up_onset="<results>/data/pile_up_onset.csv",
        pile_up="<results>/tables/pile_up.csv",
        pile_up_onsets="<results>/tables/pile_up_onsets.csv",
    log:
        "<results>/logs/pile_up.log",
        benchmark="<results>/benchmarks/pile_up.tsv",
    params:
        branch=SETTINGS.branches["pile_up"],
        rows=ROWS["pile_up"],
        code=study_code("pile_up"),
    script:
        "../scripts/run_study.py"


rule laboratory_sensitivity:
    """tables/laboratory_sensitivity.csv: means with each declared spread halved and doubled."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        laboratory_sensitivity="<results>/tables/laboratory_sensitivity.csv",
    log:
        "<results>/logs/laboratory_sensitivity.log",
        benchmark="<results>/benchmarks/laboratory_sensitivity.tsv",
    params:
        branch=SETTINGS.branches["laboratory_sensitivity"],
        rows=ROWS["laboratory_sensitivity"],
        code=study_code("laboratory_sensitivity"),
    script:
        "../scripts/run_study.py"
