"""Simulated recordings of one study of J's claims: errors of every method -> CSV."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.files import write_csv
    from mocap_metrology.lighthouse.calibrate.pnp import opencv_is_missing
    from mocap_metrology.papers.studies.study import recordings_of

    params = snakemake.params
    name = snakemake.wildcards.study
    if name == "lasers" and (why := opencv_is_missing()):
        log.warning("study lasers: %s", why)
    rows = recordings_of(name, params.settings, params.seed, log.info)
    without = dict.fromkeys(("error_mm", "error_deg"), float("nan"))  # an empty cell
    write_csv(snakemake.output[0], [row | without if row["why"] else row for row in rows])
    log.info("%d errors", len(rows))
