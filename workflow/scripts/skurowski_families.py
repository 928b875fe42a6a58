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
    filtered = gather.filter_sentence(next(iter(found.values()))[1])
    limits_s = snakemake.params.get("left_out")
    lacking = allan_families.guess_a1(limits_s) if limits_s else ""

    def of(shown):
        """Deviations with the source line, and with what captions add, of the recordings shown."""
        source, remarks = gather.sources({name: every[name] for name in shown}, lengths, paper)
        return allan, source, f"{filtered} {remarks} {lacking}".strip()

    types = allan_families.types_of(rows).values()
    makers = {
        "08": lambda: allan_families.failing_figure(rows, *of(rows), confidence),
        "12": lambda: allan_families.numbers_figure(rows, *of(rows)),
        "13": lambda: allan_families.types_figure(rows, *of(types), confidence),
        "A1": lambda: allan_families.repaired_figure(rows, others, *of(every), confidence),
    }
    for path in (Path(path) for path in snakemake.output if path.endswith(".svg")):
        save(makers[path.stem[-2:]](), path)
        log.info("%s", path.stem)
