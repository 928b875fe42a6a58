"""Read a whole recording; check.json states whether it can be used, with remarks."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.files import empty_folder, write_json
    from mocap_metrology.pipeline.checking import Asked, read_checked, refused

    given = snakemake.params
    how = given.still["range_mm"], given.horizon_s, given.second_opinion
    try:
        check, _ = read_checked(Asked(**given.row | {"paths": list(snakemake.input)}), *how)
    except Refusal as refusal:
        columns = 'write "accept" in column truncated of the sheet', "column unit of the sheet"
        check = refused(refusal, *columns)
        empty_folder(Path(snakemake.output[0]).parent)  # results of an earlier input
    log.info("%s", check)
    write_json(snakemake.output[0], check)
