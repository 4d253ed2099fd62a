"""Figures: results/figures/figNN.svg and .png, one rule of its own name per registry entry."""

for figure in FIGURES:

    rule:
        name:
            figure
        input:
            **{table: f"<results>/data/{table}.csv" for table in FIGURES[figure].data},
            **digitised_file(figure),
        output:
            svg=report(
                f"<results>/figures/{figure}.svg",
                caption="../report/figure.rst",
                category="Figures",
                labels={"figure": figure, "title": FIGURES[figure].title},
            ),
            png=f"<results>/figures/{figure}.png",
        log:
            f"<results>/logs/{figure}.log",
            benchmark=f"<results>/benchmarks/{figure}.tsv",
        # Nothing but the report waits for a figure; studies wait for studies.
        priority: -1
        params:
            entry=FIGURE_ENTRIES[figure],
            code=figure_code(figure),
        script:
            "../scripts/draw_figure.py"
