"""Two objects on a bar, tracked with the stations of a calibration -> bar.json, bar.csv."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.accuracy.bar import BarEntry
    from mocap_metrology.calibration.bar import bar
    from mocap_metrology.calibration.sweeps import Entry
    from mocap_metrology.settings import Bar, Lighthouse

    given, files = snakemake.params, dict(snakemake.input.items())
    other = Entry(**given.other) if "other_dump" in files else None
    settings, limits = Lighthouse(**given.lighthouse), Bar(**given.limits)
    found = bar(
        Entry(**given.row),
        BarEntry(**given.bar),
        files,
        settings,
        limits,
        dict(snakemake.output.items()),
        other,
    )
    log.info("%s", found.get("refused") or found["reason"])
