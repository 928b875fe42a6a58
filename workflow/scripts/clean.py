"""Recording, measured or simulated -> trajectories.parquet, clean.parquet, outliers.csv; check.json
states whether a measured one can be used, truth.json what a simulated one is made of."""

from step import refusal_of, step

with step(snakemake):
    from pathlib import Path

    from mocap_metrology.recording.clean import Entry, clean, refuse
    from mocap_metrology.settings import Settings

    params, folder = snakemake.params, Path(snakemake.output.clean).parent
    origin, settings = dict(params.origin), Settings(**params.settings)
    if origin["twin"]:
        from mocap_metrology.recording.clean import simulated

        (twin,) = params.twin.values()
        with simulated(twin, settings.seed, folder) as path:
            clean(Entry([str(path)], **params.entry), origin, settings, folder)
    else:
        entry = Entry(list(snakemake.input), **params.entry)
        try:
            clean(entry, origin, settings, folder)
        except Exception as error:
            refuse(refusal_of(error, snakemake, folder), entry, origin, folder)
