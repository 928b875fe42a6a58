"""noise.csv and what was fitted -> fit/<series>: data, models, components and residuals."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_table
    from mocap_metrology.present.fits.fit_figure import fit_figure
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.recording.recording_figures import source_words
    from mocap_metrology.present.tables import read_noise

    name, folder = snakemake.wildcards.recording, Path(snakemake.output[0])
    folder.mkdir(parents=True, exist_ok=True)
    rows = read_noise(snakemake.input.noise)
    allan, origin = read_table(snakemake.input.allan)
    shown = allan["estimator"] == "oadev"
    periodogram, _ = read_table(snakemake.input.periodogram)
    source = f"Source: {source_words(origin)}."
    remarks = (
        f"As recorded, beyond {origin['noise']['mask_sigma']:g} sigma masked; components are those "
        "of the likelihood estimator."
    )
    for series in dict.fromkeys(row["series"] for row in rows):
        own = [row for row in rows if row["series"] == series and row["status"] != "refused"]
        if not own:
            log.info("%s: no figure, as there are no coefficients", series)
            continue
        save(
            fit_figure(
                f"{name}, {series}: noise model",
                {k: v[shown & (allan["series"] == series)] for k, v in allan.items()},
                {k: v[periodogram["series"] == series] for k, v in periodogram.items()},
                {
                    estimator: [row for row in own if row["estimator"] == estimator]
                    for estimator in dict.fromkeys(row["estimator"] for row in own)
                },
                origin["frame_rate_hz"],
                source,
                remarks,
            ),
            folder / series,
        )
        log.info("%s: drawn", series)
