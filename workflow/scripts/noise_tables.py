"""Tables of the noise in a group: Gaussian model, outliers, Allan deviations, coefficients."""

from step import step

with step(snakemake):
    from pathlib import Path

    import pandas as pd

    from mocap_metrology.common.files import read_table
    from mocap_metrology.noise.assess.allan_summary import allan_summary
    from mocap_metrology.noise.fit.estimates import read_noise
    from mocap_metrology.papers.subsets import source_of
    from mocap_metrology.present import tables
    from mocap_metrology.present.groups import group_tables
    from mocap_metrology.present.text import captions

    rows, group = snakemake.params.rows, snakemake.wildcards.group
    source = {row["recording"]: source_of(row) for row in rows}
    allan = dict(zip(source, map(read_table, snakemake.input.allan), strict=True))
    origins = {name: origin for name, (_, origin) in allan.items()}
    sentence = " ".join(tables.sources_of(origins))
    stem = str(Path(snakemake.output[0])).removesuffix("_gaussian.csv")

    def gathered(paths):
        parts = []
        for name, path in zip(source, paths, strict=True):
            part = tables.read(path).drop(columns="recording", errors="ignore")
            part.insert(0, "recording", name)
            part.insert(1, "source", source[name])
            parts.append(part)
        return pd.concat(parts).to_dict("records")

    def write(kind, rows, title, caption):
        tables.write(f"{stem}_{kind}", rows, f"{group}: {title}", f"{caption} {sentence}")

    write("gaussian", gathered(snakemake.input.gaussian), "Gaussian model", captions.GAUSSIAN_TABLE)
    write("outliers", gathered(snakemake.input.outliers), "outliers", captions.OUTLIER_TABLE)
    summary = []
    for name, path in zip(source, snakemake.input.outliers, strict=True):
        expected = tables.read(path)["series"].tolist()
        summary += allan_summary(name, source[name], allan[name][0], expected)
    write("allan", summary, "Allan deviations", captions.ALLAN_TABLE)
    coefficients = dict(zip(source, map(read_noise, snakemake.input.noise), strict=True))
    noise = group_tables.noise_table(coefficients, source)
    caption = f"{group_tables.CAPTION} {sentence}"
    text = group_tables.noise_markdown(noise, f"{group}: noise coefficients", caption)
    tables.write_with(f"{stem}_noise", noise, text, group_tables.COLUMNS)
