"""verdict.json of every recording of a group -> its table of verdicts."""

from step import step

with step(snakemake) as log:
    import json
    from pathlib import Path

    from mocap_metrology.present import tables
    from mocap_metrology.present.verdict import words as verdict

    found = [json.loads(Path(path).read_text("utf-8")) for path in snakemake.input.verdicts]
    rows = [verdict.summary_row(one) for one in found]
    sentence = tables.source_sentence(
        {row["recording"]: row["source"] for row in rows}, snakemake.config["duration_s"]
    )
    tables.write(
        snakemake.output.csv,
        rows,
        f"{snakemake.wildcards.group}: verdicts",
        f"{verdict.CAPTION} {sentence}",
    )
    log.info("%d recordings", len(rows))
