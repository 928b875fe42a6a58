"""Tables of one group: its subsets, its verdicts."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_json, write_json
    from mocap_metrology.present import tables
    from mocap_metrology.present.groups import group_tables
    from mocap_metrology.present.groups.group_tables import multiqc
    from mocap_metrology.present.text import captions
    from mocap_metrology.present.verdict import words

    rows, group = snakemake.params.rows, snakemake.wildcards.group
    verdicts = list(map(read_json, snakemake.input.verdicts))
    lengths = {one["recording"]: one["duration_s"] for one in verdicts}
    of_rows = {row["recording"]: row for row in rows}
    sentence = " ".join(tables.sources(of_rows, lengths, paper=False))
    stem = str(Path(snakemake.output[0])).removesuffix("_subsets.csv")

    def write(kind, rows, title, caption):
        tables.write(f"{stem}_{kind}", rows, f"{group}: {title}", f"{caption} {sentence}")

    write("subsets", group_tables.subsets(rows), "recordings and cameras", group_tables.SUBSETS)
    summary = list(map(words.summary_row, verdicts))
    write("summary", summary, "verdicts", captions.SUMMARY_TABLE)
    write_json(snakemake.output.multiqc, multiqc(group, summary))
    log.info("%s: %d recordings", group, len(rows))
