"""Tables 3, 4 and A1-A3 and Figures 6 and 9-17 of S."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.skurowski.results import Recordings, pictures, write_tables
    from mocap_metrology.settings import Settings

    params, results = snakemake.params, Path(snakemake.output[0]).parents[1]
    recordings = Recordings(
        results / "recordings",
        {row["recording"]: row for row in params.rows},
        params.twins,
        [Path(path).parent.name for path in snakemake.input.expected],
        [Path(path).parent.name for path in snakemake.input.clean],
        Settings(**params.settings),
    )
    for line in write_tables(recordings, results / "tables"):
        log.info("%s", line)
    for number, picture in pictures(recordings):
        save(picture, results / f"figures/skurowski_fig{number:02d}")
        log.info("Figure %d", number)
