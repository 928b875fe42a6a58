"""Tables 1 and 2 and Figures 1-3 of S, which need no recording, and what is not regenerated."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.papers import subsets
    from mocap_metrology.papers.power_laws import table_1
    from mocap_metrology.present import tables
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.skurowski import appendix
    from mocap_metrology.present.skurowski import theory_figures as theory
    from mocap_metrology.present.text import captions

    folder, paper = Path(snakemake.output[0]).parents[1], captions.PAPERS["skurowski"]
    laws, types, missing = table_1(), subsets.table_2(), theory.left_out()
    laws_shown = [{column: row[column] for column in appendix.TABLE_1_SHOWN} for row in laws]

    def write(name, rows, shown, title, caption):
        text = tables.markdown(shown, title, caption)
        tables.write_with(folder / "tables" / name, rows, text)
        log.info("%s: %d rows", name, len(rows))

    title = f"{paper}, Table 1: power-law noises"
    write("skurowski_table1", laws, laws_shown, title, captions.TABLE_1)
    title, shown = f"{paper}, Table 2: cameras", subsets.side_by_side()
    write("skurowski_table2", types, shown, title, captions.TABLE_2)
    title = "Left out: figures of both papers that are not regenerated"
    write("left_out", missing, missing, title, captions.LEFT_OUT_TABLE)
    figures = (theory.model_figure, theory.standard_error_figure, theory.slopes_figure)
    for number, figure in enumerate(figures, start=1):
        save(figure(), folder / "figures" / f"skurowski_fig{number:02d}")
