"""Recording of a bar that is moved, measured or simulated -> bar.parquet; check.json states whether
a measured one can be used, truth.json what a simulated one is made of."""

from step import refusal_of, step

with step(snakemake):
    from pathlib import Path

    from mocap_metrology.accuracy.bar import BarEntry
    from mocap_metrology.common.files import REFUSED, write_json, write_table
    from mocap_metrology.recording.bar import read_bar, write_take
    from mocap_metrology.recording.clean import Entry, refused_in_sheet, simulated
    from mocap_metrology.settings import Settings

    params, path = snakemake.params, Path(snakemake.output.take)
    origin, settings, bar_row = (
        dict(params.origin),
        Settings(**params.settings),
        BarEntry(**params.bar),
    )
    if origin["twin"]:
        (twin,) = params.twin.values()
        with simulated(twin, settings.seed, path.parent) as simulation:
            entry = Entry([str(simulation)], **params.entry)
            write_take(read_bar(entry, bar_row, settings, origin), bar_row, path)
    else:
        entry = Entry(list(snakemake.input), **params.entry, sha256=params.sha256)
        try:
            reading = read_bar(entry, bar_row, settings, origin)
            write_take(reading, bar_row, path)
            write_json(snakemake.output.check, reading.check)
        except Exception as error:
            check = refused_in_sheet(refusal_of(error, snakemake, path.parent))
            write_json(snakemake.output.check, check)
            write_table(path, {"length_mm": []}, {**origin, REFUSED: check["why"]})
