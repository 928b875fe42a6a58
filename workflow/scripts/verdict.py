"""Results of one recording -> diagnosis.json with its tables, verdict.json, both in words in the
log; figures of both, of the Allan deviations, the spectrum, the trajectory, and of the fits."""

from step import step

with step(snakemake) as log:
    import json
    from pathlib import Path

    from mocap_metrology.common.files import read_metadata, read_series, whole_folder, write_json
    from mocap_metrology.pipeline import figures
    from mocap_metrology.pipeline.judging import Evidence, diagnosed, diagnosis_settings, judged
    from mocap_metrology.pipeline.tables import Table
    from mocap_metrology.present.tables import read_noise, read_outliers
    from mocap_metrology.present.verdict.words import verdict_lines
    from mocap_metrology.settings import Diagnosis, Still, Verdict

    given, files, folder = snakemake.params, snakemake.input, Path(snakemake.output.json).parent
    name, limits = snakemake.wildcards.recording, Verdict(**given.verdict)
    noise, psd, raw = read_noise(files.noise), Table.read(files.psd), Table.open(files.raw)

    settings = diagnosis_settings(
        Diagnosis(**given.diagnosis), Still(**given.still), limits.horizon_s
    )
    diagnosis = diagnosed(raw, psd, noise, settings)
    for one in diagnosis.sentences:
        log.info("%s: %s: %s", one.severity, one.kind, one.words)
    diagnosis.write(folder, name, raw.origin["source"])
    figures.draw_diagnosis(diagnosis, raw.origin, settings.false_alarm, folder / "diagnosis")
    del diagnosis

    checks = [json.loads(Path(path).read_text("utf-8")) for path in files.check]
    allan = Table.read(files.allan)
    evidence = Evidence(
        read_series(files.clean),
        read_metadata(files.clean),
        allan.columns,
        noise,
        read_outliers(files.outliers),
        json.loads((folder / "diagnosis.json").read_text("utf-8")),
        [words for check in checks for words in check["warnings"]],
    )
    found = judged(evidence, given.row, limits, given.confidence)
    write_json(snakemake.output.json, found)
    log.info("%s", "\n".join(verdict_lines(found)))

    figures.draw_verdict(
        json.loads(Path(snakemake.output.json).read_text("utf-8")), folder / "verdict"
    )
    figures.draw_allan(allan, folder / "adev")
    figures.draw_psd(psd, folder / "psd")
    figures.draw_trajectory(raw, Table.open(files.clean), folder / "trajectory")
    chosen = None if given.fits is None else set(given.fits)
    with whole_folder(snakemake.output.fits) as fits:
        drawn = figures.draw_fits(noise, allan, Table.read(files.periodogram), fits, chosen)
    log.info("fits drawn: %s", ", ".join(drawn) or "none")
