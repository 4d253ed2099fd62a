"""Figures: one job draws those of a study; each is a target of its own, as in `snakemake fig17`."""

FIGURES_OF = {}
for figure, spec in FIGURES.items():
    FIGURES_OF.setdefault(spec.study, []).append(figure)

for study, drawn in FIGURES_OF.items():

    rule:
        name:
            f"{study}_figures"
        input:
            **data(*(table for figure in drawn for table in FIGURES[figure].data)),
            **{f"{name}_digitised": DIGITISED[name].path for name in drawn if name in DIGITISED},
        output:
            [
                report(
                    f"<results>/figures/{figure}.svg",
                    caption="../report/figure.rst",
                    category="Figures",
                    labels={"figure": figure, "title": FIGURES[figure].title},
                )
                for figure in drawn
            ],
            [
                f"<results>/figures/{figure}.{kind}"
                for figure in drawn
                for kind in ("png", "pdf", "csv")
            ],
        log:
            f"<results>/logs/{study}_figures.log",
        benchmark:
            f"<results>/benchmarks/{study}_figures.tsv"
        # Nothing but the report waits for a figure; studies wait for studies.
        priority: -1
        params:
            **code(*sorted({FIGURES[figure].module for figure in drawn}), script="draw_figures.py"),
            entries=Digested({figure: FIGURE_ENTRIES[figure] for figure in drawn}),
        script:
            "../scripts/draw_figures.py"


for figure in FIGURES:

    rule:
        name:
            figure
        input:
            [f"<results>/figures/{figure}.{kind}" for kind in FORMATS],
            # Deleted by hand, they are made again, too.
            data(*FIGURES[figure].data).values(),
            "<results>/tables/inputs.csv",
