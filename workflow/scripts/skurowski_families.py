"""Figures 8, 12 and 13, or A1, of S: Allan deviations of recordings side by side."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_table
    from mocap_metrology.present import tables
    from mocap_metrology.present.drawing.style import save_figure
    from mocap_metrology.present.families import paper

    rows = {row["recording"]: row for row in snakemake.params.rows}
    others = {row["recording"]: row for row in snakemake.params.get("others", [])}
    every = rows | others
    source = tables.source_sentence({name: tables.source_of(row) for name, row in every.items()})
    found = {
        name: read_table(path) for name, path in zip(every, snakemake.input.allan, strict=True)
    }
    confidence = next(iter(found.values()))[1]["allan"]["confidence"]
    allan = {name: columns for name, (columns, _) in found.items()}
    makers = {
        "08": lambda: paper.failing_figure(rows, allan, source, confidence),
        "12": lambda: paper.numbers_figure(rows, allan, source),
        "13": lambda: paper.types_figure(rows, allan, source, confidence),
        "A1": lambda: paper.repaired_figure(rows, others, allan, source, confidence),
    }
    for path in (Path(path) for path in snakemake.output if path.endswith(".svg")):
        save_figure(makers[path.stem[-2:]](), path.with_suffix(""))
        log.info("%s", path.stem)
