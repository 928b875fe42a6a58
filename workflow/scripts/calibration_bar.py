"""Two objects on a bar, tracked with the stations of a calibration -> bar.json, bar.csv."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.accuracy.bar import BarEntry
    from mocap_metrology.calibration.bar import bar
    from mocap_metrology.calibration.sweeps import Entry
    from mocap_metrology.settings import Bar, Lighthouse

    params, files = snakemake.params, dict(snakemake.input.items())
    other = Entry(**params.other) if "other_dump" in files else None
    settings, limits = Lighthouse(**params.lighthouse), Bar(**params.limits)
    document = bar(
        Entry(**params.row),
        BarEntry(**params.bar),
        files,
        settings,
        limits,
        dict(snakemake.output.items()),
        other,
    )
    log.info("%s", document.get("refused") or document["reason"])
