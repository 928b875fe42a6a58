"""Figures 6 and 14-17 of S: fits, coefficients over cameras, and the periodic disturbance."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_metadata, read_table
    from mocap_metrology.noise.fit.estimates import read_noise
    from mocap_metrology.noise.fit.estimators import NoiseSettings, regression
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.skurowski import appendix, gather
    from mocap_metrology.present.skurowski.coefficients import colour_figure, correlated_figure
    from mocap_metrology.present.skurowski.series_figures import periodic_figure, regression_figure
    from mocap_metrology.settings import Settings

    given, titles, series = snakemake.params, gather.TITLES, gather.SERIES
    rows = {row["recording"]: row for row in given.rows}
    files = snakemake.input
    expected = {Path(path).parent.name: read_noise(path) for path in files.expected}
    noise = dict(zip(rows, map(read_noise, files.noise), strict=True))
    allan_of = dict(zip(rows, files.allan, strict=True))
    psd_of = dict(zip(rows, files.psd, strict=True))
    made = [row for t in appendix.tables_a(rows, noise, expected).values() for row in t]
    lengths = {name: gather.length_s(read_metadata(path)) for name, path in allan_of.items()}
    source, remarks = gather.sources(rows, lengths)

    name = gather.of_regression(rows)
    allan, origin = read_table(allan_of[name])
    own = (allan["series"] == series) & (allan["estimator"] == "oadev") & (allan["avar_mm2"] > 0)
    rate = origin["frame_rate_hz"]
    subset = rows[name]["camera_type"], rows[name]["n_cameras"]
    settings = NoiseSettings.of(Settings(**given.settings), rate, subset=subset)
    run, ordinary = regression(allan["m"][own], allan["avar_mm2"][own], rate, settings, series)
    spectra = {}
    for label, other in gather.largest(rows).items():
        psd, _ = read_table(psd_of[other])
        pick = psd["series"] == series
        spectra[label] = psd["f_hz"][pick], psd["psd_mm2_hz"][pick]
    source_6, made_6 = gather.sources({name: rows[name]}, lengths)
    remarks_6 = f"Series {series} of recording {name}. {gather.filter_sentence(origin)} {made_6}"
    how_17 = gather.sources({n: rows[n] for n in gather.largest(rows).values()}, lengths)
    figures = {
        6: regression_figure(
            (allan["tau_s"][own], allan["adev_mm"][own]),
            run.starts,
            ordinary.model,
            run.estimate.model,
            rate,
            (titles[6], source_6, remarks_6),
            form=settings.form,
        ),
        14: colour_figure(made, titles[14], source, remarks),
        15: colour_figure(made, titles[15], source, remarks, logarithmic=False),
        16: correlated_figure(made, titles[16], source, remarks),
        17: periodic_figure(spectra, gather.LINE_HZ, titles[17], *how_17),
    }
    for number, figure in figures.items():
        save(figure, Path(snakemake.output[0]).parent / f"skurowski_fig{number:02d}")
        log.info("Figure %d", number)
