"""Results of one recording -> verdict.json, in words in the log; figures of the verdict, the Allan
deviations, the spectrum, the trajectory, and of the fit of each series."""

from step import step

with step(snakemake) as log:
    import json
    from pathlib import Path

    import pandas as pd

    from mocap_metrology.common.files import read_metadata, read_series, whole_folder, write_json
    from mocap_metrology.pipeline.figures import (
        draw_allan,
        draw_fits,
        draw_psd,
        draw_trajectory,
        draw_verdict,
    )
    from mocap_metrology.pipeline.judging import Evidence, judged
    from mocap_metrology.pipeline.settings import Verdict
    from mocap_metrology.pipeline.tables import Table
    from mocap_metrology.present.tables import read_noise
    from mocap_metrology.present.verdict.words import verdict_lines

    given, files, folder = snakemake.params, snakemake.input, Path(snakemake.output.json).parent
    checks = [json.loads(Path(path).read_text("utf-8")) for path in files.check]
    noise, allan = read_noise(files.noise), Table.read(files.allan)
    evidence = Evidence(
        read_series(files.clean),
        read_metadata(files.clean),
        allan.columns,
        noise,
        pd.read_csv(files.outliers).to_dict("records"),
        json.loads(Path(files.diagnosis).read_text("utf-8")),
        [words for check in checks for words in check["warnings"]],
    )
    found = judged(evidence, given.row, Verdict(**given.verdict), given.confidence)
    write_json(snakemake.output.json, found)
    log.info("%s", "\n".join(verdict_lines(found)))

    draw_verdict(json.loads(Path(snakemake.output.json).read_text("utf-8")), folder / "verdict")
    draw_allan(allan, folder / "adev")
    draw_psd(Table.read(files.psd), folder / "psd")
    draw_trajectory(Table.open(files.raw), Table.open(files.clean), folder / "trajectory")
    chosen = None if given.fits is None else set(given.fits)
    with whole_folder(snakemake.output.fits) as fits:
        drawn = draw_fits(noise, allan, Table.read(files.periodogram), fits, chosen)
    log.info("fits drawn: %s", ", ".join(drawn) or "none")
