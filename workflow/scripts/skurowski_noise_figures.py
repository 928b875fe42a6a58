"""Figures 6 and 14-17 of S: fits, coefficients over cameras, and the periodic disturbance."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_table
    from mocap_metrology.noise import noise_files
    from mocap_metrology.noise.estimators import regression
    from mocap_metrology.present import tables
    from mocap_metrology.present.drawing.style import save_figure
    from mocap_metrology.present.groups.noise import read_noise
    from mocap_metrology.present.skurowski import appendix, paper_noise
    from mocap_metrology.present.skurowski.coefficients import colour_figure
    from mocap_metrology.present.skurowski.correlated import correlated_figure
    from mocap_metrology.present.skurowski.periodic import periodic_figure
    from mocap_metrology.present.skurowski.regression import regression_figure

    given, titles, series = snakemake.params, paper_noise.TITLES, paper_noise.SERIES
    rows = {row["recording"]: row for row in given.rows}
    folders = dict(zip(rows, (Path(path).parent for path in snakemake.input.noise), strict=True))
    expected = {Path(path).parent.name: read_noise(path) for path in snakemake.input.expected}
    noise = {name: read_noise(folder / "noise.csv") for name, folder in folders.items()}
    made = [row for t in appendix.tables_a(rows, noise, expected).values() for row in t]
    source = tables.source_sentence({name: tables.source_of(row) for name, row in rows.items()})

    name = paper_noise.of_regression(rows)
    allan, origin = read_table(folders[name] / "allan.parquet")
    own = (allan["series"] == series) & (allan["estimator"] == "oadev") & (allan["avar_mm2"] > 0)
    tau0 = 1 / origin["frame_rate_hz"]
    settings = noise_files.settings(
        given.noise, given.annealing, given.allan, given.hampel, origin["frame_rate_hz"]
    )
    run, ordinary = regression(
        allan["m"][own], allan["avar_mm2"][own], tau0, settings, rows[name], series, given.seed
    )
    spectra = {}
    for label, other in paper_noise.largest(rows).items():
        psd, _ = read_table(folders[other] / "psd.parquet")
        pick = psd["series"] == series
        spectra[label] = psd["f_hz"][pick], psd["psd_mm2_hz"][pick]
    figures = {
        6: regression_figure(
            allan["tau_s"][own],
            allan["adev_mm"][own],
            run.starts,
            ordinary.model,
            run.estimate.model,
            tau0,
            titles[6],
            f"{name}, {series}. {source}",
            form=settings.form,
        ),
        14: colour_figure(made, titles[14], source),
        15: colour_figure(made, titles[15], source, logarithmic=False),
        16: correlated_figure(made, titles[16], source),
        17: periodic_figure(spectra, paper_noise.LINE_HZ, titles[17], source),
    }
    for number, figure in figures.items():
        save_figure(figure, Path(snakemake.output[0]).parent / f"skurowski_fig{number:02d}")
        log.info("Figure %d", number)
