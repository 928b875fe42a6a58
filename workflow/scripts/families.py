"""All recordings of a group side by side: Allan deviations, coefficients, correlated noise."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import read_table
    from mocap_metrology.noise.fit.estimates import read_noise
    from mocap_metrology.present.groups.adev import family_figure, family_of
    from mocap_metrology.present.groups.coefficients import coefficients_figure, correlated_figure
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.skurowski import gather

    given, group = snakemake.input, snakemake.wildcards.group
    rows = {row["recording"]: row for row in snakemake.params.rows}
    family = family_of(rows)
    allan = {name: read_table(path) for name, path in zip(rows, given.allan, strict=True)}
    texts = gather.sources_of({name: origin for name, (_, origin) in allan.items()})
    noise = {name: read_noise(path) for name, path in zip(rows, given.noise, strict=True)}
    series = {name: list(dict.fromkeys(row["series"] for row in of)) for name, of in noise.items()}
    confidence = next(iter(allan.values()))[1]["allan"]["confidence"]
    columns = {name: found[0] for name, found in allan.items()}
    figures = {
        "adev": family_figure(
            family, columns, series, f"{group}: Allan deviation", *texts, confidence
        ),
        "coefficients": coefficients_figure(family, noise, f"{group}: power-law noise", *texts),
        "correlated": correlated_figure(family, noise, f"{group}: correlated noise", *texts),
    }
    for name, picture in figures.items():
        save(picture, Path(snakemake.output[0]).parent / f"{group}_{name}")
    log.info("%s: %d recordings", group, len(rows))
