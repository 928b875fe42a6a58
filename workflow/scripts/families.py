"""All recordings of a group side by side: Allan deviations, coefficients, correlated noise."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_table
    from mocap_metrology.noise.fit.estimates import read_noise
    from mocap_metrology.present import tables
    from mocap_metrology.present.groups.figures import (
        coefficients_figure,
        correlated_figure,
        family_figure,
        family_of,
    )
    from mocap_metrology.present.plot.figure import Texts, save

    inputs, group = snakemake.input, snakemake.wildcards.group
    rows = {row["recording"]: row for row in snakemake.params.rows}
    family = family_of(rows)
    allan = {name: read_table(path) for name, path in zip(rows, inputs.allan, strict=True)}
    texts = tables.sources_of({name: origin for name, (_, origin) in allan.items()})
    noise = {name: read_noise(path) for name, path in zip(rows, inputs.noise, strict=True)}
    series = {name: list(dict.fromkeys(row["series"] for row in of)) for name, of in noise.items()}
    confidence = next(iter(allan.values()))[1]["allan"]["confidence"]
    columns = {name: table[0] for name, table in allan.items()}
    adev, laws, correlated = (
        Texts(f"{group}: {title}", *texts)
        for title in ("Allan deviation", "power-law noise", "correlated noise")
    )
    figures = {
        "adev": family_figure(family, columns, series, adev, confidence),
        "coefficients": coefficients_figure(family, noise, laws),
        "correlated": correlated_figure(family, noise, correlated),
    }
    for name, picture in figures.items():
        save(picture, Path(snakemake.output[0]).parent / f"{group}_{name}")
    log.info("%s: %d recordings", group, len(rows))
