"""Decode a whole recording; say in check.json whether it can be used, and what to beware of."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from lighthouse_steps import decoded

    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.files import empty_folder, sha256, write_json

    row = snakemake.params.row
    check = {"ok": True, "why": "", "warnings": [], "notes": []}
    try:
        if row["sha256"] and sha256(row["path"]) != row["sha256"]:
            name, found = Path(row["path"]).name, sha256(row["path"])
            raise Refusal(f"{name}: SHA-256 is {found}; expected {row['sha256']}")
        files = dict(snakemake.input.items())
        recording = decoded(files, row, snakemake.params.lighthouse)
        check["notes"] = recording.notes
        check["warnings"] = [
            f"{station.role}: no factory values ({station.why}); expected errors of centimetres"
            for station in recording.stations
            if station.factory is None
        ]
    except Refusal as refusal:
        check |= {"ok": False, "why": str(refusal)}
        empty_folder(Path(snakemake.output[0]).parent)  # results of an earlier input
    log.info("%s", check)
    write_json(snakemake.output[0], check)
