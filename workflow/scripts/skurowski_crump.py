"""Figure 7 of S: a shock in the trajectories, and in the Allan deviation of the distance."""

from step import step

with step(snakemake) as log:
    from coordinates import read_coordinates

    from mocap_metrology.common.files import read_table
    from mocap_metrology.noise.series import all_series
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.skurowski import gather
    from mocap_metrology.present.skurowski.allan_families import TITLES
    from mocap_metrology.present.skurowski.crump import Shaken, crump_figure, guessed

    given, rows = snakemake.input, snakemake.params.rows
    _, raw, origin = read_coordinates(given.raw[0])
    raw = dict(all_series(raw, [tuple(pair) for pair in origin["pairs"]]))
    (allan, settings), *other = [read_table(path) for path in given.allan]
    shaken = Shaken(
        raw,
        read_coordinates(given.clean[0])[1],
        allan,
        origin["frame_rate_hz"],
        settings["allan"]["min_coverage"],
    )
    every = {row["recording"]: row for row in rows}
    origins = [settings, *(of for _, of in other)]
    lengths = {row["recording"]: gather.length_s(of) for row, of in zip(rows, origins, strict=True)}
    label = rows[1]["recording"] if other else ""
    quiet = (f"{label}, without a shock", other[0][0]) if other else None
    apart = f"{label} is another realisation of the noise: they differ by chance. " if other else ""
    source, remarks = gather.sources(every, lengths)
    remarks = (
        f"Recording {rows[0]['recording']}; the paper shows one of all its cameras. "
        f"{apart}{guessed(snakemake.params.crumps)}{remarks}"
    )
    save(crump_figure(shaken, quiet, TITLES[7], source, remarks), snakemake.output[0])
    log.info("%s: drawn", rows[0]["recording"])
