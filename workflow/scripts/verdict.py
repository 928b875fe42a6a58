"""Results of one recording -> verdict.json; the verdict in words goes to the log."""

from step import step

with step(snakemake) as log:
    import json
    from pathlib import Path

    import pandas as pd

    from mocap_metrology.common.files import read_metadata, read_series, read_table, write_json
    from mocap_metrology.pipeline.judging import Evidence, judged
    from mocap_metrology.pipeline.settings import Verdict
    from mocap_metrology.present.tables import read_noise
    from mocap_metrology.present.verdict.words import verdict_lines

    given, files = snakemake.params, snakemake.input
    checks = [json.loads(Path(path).read_text("utf-8")) for path in files.check]
    evidence = Evidence(
        read_series(files.clean),
        read_metadata(files.clean),
        read_table(files.allan)[0],
        read_noise(files.noise),
        pd.read_csv(files.outliers).to_dict("records"),
        json.loads(Path(files.diagnosis).read_text("utf-8")),
        [words for check in checks for words in check["warnings"]],
    )
    found = judged(evidence, given.row, Verdict(**given.verdict), given.confidence)
    write_json(snakemake.output[0], found)
    log.info("%s", "\n".join(verdict_lines(found)))
