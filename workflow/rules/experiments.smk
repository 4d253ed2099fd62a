"""Section 2: drawings of the set-ups, virtual experiments, and the laboratory's own accuracy."""


use rule study as schematics with:
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
        study="schematics",
    params:
        **parameters("schematics"),


use rule study as normal_experiments with:
    """data/fig04.csv, data/fig05.csv: normal impacts seen by the PDPA; tables of the same."""
    input:
        **tables("calibration"),
    output:
        **tables("normal_experiments", "size_effects"),
        **data("fig04", "fig05"),
    pathvars:
        study="normal_experiments",
    params:
        **parameters("normal_experiments"),


use rule study as oblique_experiments with:
    """data/fig06.csv to fig12.csv: oblique impacts seen by the PTIS; table of the experiments."""
    input:
        **tables("calibration"),
    output:
        **tables("oblique_experiments"),
        **data("fig06", "fig07", "fig08", "fig09", "fig10", "fig11", "fig12"),
        **data("fig23_points"),
    pathvars:
        study="oblique_experiments",
    params:
        **parameters("oblique_experiments"),


use rule study as pair_search with:
    """tables/pairing_quality.csv, surface_correction.csv; data of doppler_pairs."""
    input:
        **tables("calibration"),
    output:
        **tables("pairing_quality", "surface_correction"),
        **data("doppler_stream", "pairing_curves", "correction_curves"),
    pathvars:
        study="pair_search",
    params:
        **parameters("pair_search"),


use rule study as track_imaging with:
    """tables/ptis_range.csv: range and errors of the imaging; data of ptis_frame, ptis_accuracy."""
    output:
        **tables("ptis_range"),
        **data("ptis_frame", "ptis_pixels", "ptis_accuracy"),
    pathvars:
        study="track_imaging",
    params:
        **parameters("track_imaging"),


use rule study as campaign with:
    """tables/campaign.csv: all 187 experiments; data of campaign_map."""
    input:
        **tables("calibration"),
    output:
        **tables("campaign"),
        **data("campaign_map"),
    pathvars:
        study="campaign",
    params:
        **parameters("campaign"),


use rule study as interval_coverage with:
    """tables/interval_coverage.csv: how often 95 % intervals hold each mean; figure data."""
    input:
        **tables("calibration"),
    output:
        **tables("interval_coverage"),
        **data("coverage_by_speed", "coverage_by_angle"),
    pathvars:
        study="interval_coverage",
    params:
        **parameters("interval_coverage"),


use rule study as mechanisms with:
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
        study="mechanisms",
    params:
        **parameters("mechanisms"),


use rule study as pile_up with:
    """data/pile_up_onset.csv: spheres that end on the target; tables of shares and onsets."""
    input:
        **tables("calibration", "evidence_summary"),
    output:
        **tables("pile_up", "pile_up_onsets"),
        **data("pile_up_onset"),
    pathvars:
        study="pile_up",
    params:
        **parameters("pile_up"),


use rule study as rival_explanations with:
    """data/rival_restitution.csv; tables: what adhesion, a probe above the surface and v_c give."""
    input:
        **tables("calibration", "pile_up", "pile_up_onsets"),
    output:
        **tables("rival_explanations", "capture_evidence", "rival_forces"),
        **data("rival_restitution"),
    pathvars:
        study="rival_explanations",
    params:
        **parameters("rival_explanations"),
