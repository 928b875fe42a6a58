"""Figures 8, 12 and 13, or A1, of S: Allan deviations of recordings side by side."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_table
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.skurowski import allan_families, gather

    rows = {row["recording"]: row for row in snakemake.params.rows}
    others = {row["recording"]: row for row in snakemake.params.get("others", [])}
    every = rows | others
    found = {
        name: read_table(path) for name, path in zip(every, snakemake.input.allan, strict=True)
    }
    confidence = next(iter(found.values()))[1]["allan"]["confidence"]
    allan = {name: columns for name, (columns, _) in found.items()}
    lengths = {name: gather.length_s(origin) for name, (_, origin) in found.items()}
    paper = not others  # S: no length after repair
    source, remarks = gather.sources(every, lengths, paper)
    remarks = f"{gather.filter_sentence(next(iter(found.values()))[1])} {remarks}"
    if limits_s := snakemake.params.get("left_out"):
        remarks += " " + allan_families.guess_a1(limits_s)
    how = allan, source, remarks
    makers = {
        "08": lambda: allan_families.failing_figure(rows, *how, confidence),
        "12": lambda: allan_families.numbers_figure(rows, *how),
        "13": lambda: allan_families.types_figure(rows, *how, confidence),
        "A1": lambda: allan_families.repaired_figure(rows, others, *how, confidence),
    }
    for path in (Path(path) for path in snakemake.output if path.endswith(".svg")):
        save(makers[path.stem[-2:]](), path)
        log.info("%s", path.stem)
