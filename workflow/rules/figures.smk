"""Figures: one job draws those of an analysis; each is a target of its own, as in `snakemake fig17`."""

FIGURES_OF = {}
for figure, spec in FIGURES.items():
    FIGURES_OF.setdefault(spec.analysis, []).append(figure)

for analysis, drawn in FIGURES_OF.items():

    rule:
        name:
            f"{analysis}_figures"
        input:
            **data(*(table for figure in drawn for table in FIGURES[figure].data)),
            **{f"{name}_digitised": DIGITISED[name] for name in drawn if name in DIGITISED},
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
            [f"<results>/figures/{figure}.{kind}" for figure in drawn for kind in (*FORMATS, "csv")],
        log:
            f"<results>/logs/{analysis}_figures.log",
        benchmark:
            f"<results>/benchmarks/{analysis}_figures.tsv"
        # Nothing but the report waits for a figure; analyses wait for analyses.
        priority: -1
        params:
            **code(
                *sorted({FIGURES[figure].draw.__module__ for figure in drawn}),
                script="draw_figures.py",
            ),
            entries=Digested({figure: FIGURES[figure].entry() for figure in drawn}),
            branch=Digested(SETTINGS.branches[analysis]),
            pairs=Digested(SETTINGS.pairs_of(analysis)),
            scale=DRAWN.scale,
            palette=DRAWN.palette,
        script:
            "../scripts/draw_figures.py"


for figure in FIGURES:

    rule:
        name:
            figure
        input:
            [f"<results>/figures/{figure}.{kind}" for kind in ("svg", *FORMATS)],
            # Deleted by hand, they are made again, too.
            data(*FIGURES[figure].data).values(),
            "<results>/tables/inputs.csv",
