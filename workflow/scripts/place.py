"""clean.parquet of a moving pair -> place.csv: noise and mean of its length by place."""

from step import step

with step(snakemake) as log:
    import numpy as np

    from mocap_metrology.noise.motion.place import by_place, evenness
    from mocap_metrology.noise.series import AXES, pair_name
    from mocap_metrology.present import recording, tables
    from mocap_metrology.present.plot.figure import Texts, save
    from mocap_metrology.present.text import captions
    from mocap_metrology.recording.results import Table

    cleaned = Table.open(snakemake.input[0])
    series, origin = cleaned.coordinates, cleaned.origin
    first, second = origin["pairs"][0]
    middle = [
        (series[f"{axis}{first}"].astype(np.float64) + series[f"{axis}{second}"]) / 2
        for axis in AXES
    ]
    cell = snakemake.params.place["cell_mm"]
    name = pair_name(origin["pairs"][0], origin["pairs"])
    rows, visits = by_place(middle, series[name], cell)
    few = "" if rows else f"too few frames in any cube of {cell:g} mm; raise place.cell_mm"
    said = few or recording.place_sentence(evenness(rows, visits))
    pair = " and ".join(origin["labels"][marker - 1] for marker in origin["pairs"][0])
    words = f"Pair {pair}: {said}" if few else f"Pair {pair}. {said}"
    source = tables.source_sentence({origin["recording"]: origin["source"]})
    caption = f"{captions.PLACE_TABLE.format(cell=cell)} {words}"
    title = f"{origin['recording']}: length by place"
    tables.write(snakemake.output.csv, rows or [{"note": few}], title, f"{caption} {source}")
    texts = Texts(title, f"Source: {recording.source_words(origin)}.", caption)
    save(recording.place_figure(rows, texts), snakemake.output.svg)
    log.info("%s", words)
