"""Dump -> pulses.parquet, stations.json, sweeps.parquet: pulses, what stations tell, clean hits."""

from step import step

with step(snakemake) as log:
    from lighthouse_steps import decoded

    from mocap_metrology.common.files import sha256, versions, write_csv, write_json, write_table
    from mocap_metrology.lighthouse import columns
    from mocap_metrology.lighthouse.decode.chain import dropped_share
    from mocap_metrology.lighthouse.decode.factory_file import stations_to_json

    row, files = snakemake.params.row, snakemake.output
    found = decoded(snakemake.input, row, snakemake.params.lighthouse)
    origin = {
        "recording": row["calibration"],
        "source": row["twin"] or row["path"],
        "twin": row["twin"],
        "sha256": None if row["twin"] else sha256(snakemake.input.dump),
        "lighthouse": snakemake.params.lighthouse,
        "duration_s": found.duration_s,
        "resolution_s": found.pulses.resolution_s if found.pulses else None,
        "notes": found.notes,
        "clocks": [vars(clock) for clock in found.clocks],
        "versions": versions("numpy", "numba", "pyarrow"),
    }
    if found.pulses is None:
        table = {"start_s": [], "length_us": [], "diode": []}
    else:
        table = columns.pulses(found.pulses)
    write_table(files.pulses, table, origin, columns.PULSES_CODED)
    origin |= {"counts_by_diode": found.report, "dropped": dropped_share(found.report)}
    write_table(files.sweeps, columns.sweeps(found.hits), origin, columns.SWEEPS_CODED)
    write_csv(files.board, [dict(zip(("x_m", "y_m", "z_m"), p, strict=True)) for p in found.board])
    write_json(files.stations, stations_to_json(found.stations))
    for station in found.stations:
        log.info("%s: id %s, mode %s, %s", station.role, station.id, station.mode, station.why)
    log.info("%d hits; dropped %s; %s", len(found.hits), origin["dropped"], found.notes)
