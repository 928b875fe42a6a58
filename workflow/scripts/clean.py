"""Recording, measured or simulated -> trajectories.parquet, clean.parquet, outliers.csv; check.json
states whether a measured one can be used, truth.json what a simulated one is made of."""

from step import refusal_of, step

with step(snakemake):
    from pathlib import Path

    from mocap_metrology.recording.clean import Entry, clean, refuse
    from mocap_metrology.settings import Settings

    given, folder = snakemake.params, Path(snakemake.output.clean).parent
    origin, settings = dict(given.origin), Settings(**given.settings)
    if origin["twin"]:
        from mocap_metrology.recording.clean import simulated

        (twin,) = given.twin.values()
        with simulated(twin, settings.seed, folder) as path:
            clean(Entry([str(path)], **given.entry), origin, settings, folder)
    else:
        entry = Entry(list(snakemake.input), **given.entry)
        try:
            clean(entry, origin, settings, folder)
        except Exception as error:
            refuse(refusal_of(error, snakemake, folder), entry, origin, folder)
