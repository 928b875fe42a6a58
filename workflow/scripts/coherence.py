"""clean.parquet and a simultaneous covariate -> <group>_coherence: coherence of the noise."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.files import read_metadata, read_series
    from mocap_metrology.io.text.covariate import read_covariate
    from mocap_metrology.noise.changes.covariate import Covariate, coherence_row
    from mocap_metrology.present import tables
    from mocap_metrology.present.text import captions

    group, sources = snakemake.wildcards.group, snakemake.params.sources
    rows, alpha = [], snakemake.params.compare["alpha"]
    files = zip(sources, snakemake.input.clean, snakemake.input.covariate, strict=True)
    for name, clean, path in files:
        rate = read_metadata(clean)["frame_rate_hz"]
        try:
            covariate = Covariate(*read_covariate(path))
        except Refusal as refusal:
            log.warning("%s: %s", name, refusal)
            rows.append({"recording": name, "note": str(refusal)})
            continue
        refused = {}
        for series, values in read_series(clean):
            row = {"recording": name, "series": series}
            try:
                rows.append(row | coherence_row(values, rate, covariate, alpha))
            except Refusal as refusal:
                rows.append(row | {"note": str(refusal)})
                refused.setdefault(str(refusal), []).append(series)
        for why, series in refused.items():
            log.warning("%s: %s: %s", name, ", ".join(series), why)
    caption = f"{captions.COHERENCE_TABLE} {tables.source_sentence(sources)}"
    title = f"{group}: noise and what was recorded beside it"
    tables.write(snakemake.output.csv, rows, title, caption)
