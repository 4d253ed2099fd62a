"""The virtual laboratory: quality of its instruments and of the reduction of their data."""


rule pair_search:
    """tables/pairing_*.csv, surface_correction.csv, slow_rebounds.csv; data of doppler_pairs."""
    input:
        calibration="<results>/tables/calibration.csv",
    output:
        pairing_quality="<results>/tables/pairing_quality.csv",
        pairing_losses="<results>/tables/pairing_losses.csv",
        pairing_controls="<results>/tables/pairing_controls.csv",
        surface_correction="<results>/tables/surface_correction.csv",
        slow_rebounds="<results>/tables/slow_rebounds.csv",
        doppler_stream="<results>/data/doppler_stream.csv",
        pairing_curves="<results>/data/pairing_curves.csv",
        correction_curves="<results>/data/correction_curves.csv",
    log:
        "<results>/logs/pair_search.log",
        benchmark="<results>/benchmarks/pair_search.tsv",
    params:
        branch=SETTINGS.branches["pair_search"],
        rows=ROWS["pair_search"],
        code=study_code("pair_search"),
    script:
        "../scripts/run_study.py"


rule track_imaging:
    """tables/ptis_*.csv: range, errors and losses of the imaging; data of ptis_frame, ptis_accuracy."""
    output:
        ptis_range="<results>/tables/ptis_range.csv",
        ptis_views="<results>/tables/ptis_views.csv",
        ptis_errors="<results>/tables/ptis_errors.csv",
        ptis_agreement="<results>/tables/ptis_agreement.csv",
        ptis_losses="<results>/tables/ptis_losses.csv",
        ptis_frame="<results>/data/ptis_frame.csv",
        ptis_pixels="<results>/data/ptis_pixels.csv",
        ptis_accuracy="<results>/data/ptis_accuracy.csv",
    log:
        "<results>/logs/track_imaging.log",
        benchmark="<results>/benchmarks/track_imaging.tsv",
    params:
        branch=SETTINGS.branches["track_imaging"],
        rows=ROWS["track_imaging"],
        code=study_code("track_imaging"),
    script:
        "../scripts/run_study.py"
