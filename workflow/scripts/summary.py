"""verdict.json of every recording of a group -> its table of verdicts."""

from step import step

with step(snakemake) as log:
    import json
    from pathlib import Path

    from mocap_metrology.present import tables
    from mocap_metrology.present.skurowski import gather
    from mocap_metrology.present.verdict import words as verdict

    found = [json.loads(Path(path).read_text("utf-8")) for path in snakemake.input.verdicts]
    rows = [verdict.summary_row(one) for one in found]
    of = {one["recording"]: one for one in found}
    lengths = {name: one["duration_s"] for name, one in of.items()}
    sentence = " ".join(gather.sources(of, lengths, paper=False))
    tables.write(
        snakemake.output.csv,
        rows,
        f"{snakemake.wildcards.group}: verdicts",
        f"{verdict.CAPTION} {sentence}",
    )
    log.info("%d recordings", len(rows))
