"""Decode a whole recording; check.json states whether it can be used, with remarks."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.files import empty_folder, write_json
    from mocap_metrology.pipeline.calibration import Asked, checked
    from mocap_metrology.settings import Lighthouse

    asked = Asked(**snakemake.params.row | {"path": snakemake.input.dump})
    settings = Lighthouse(**snakemake.params.lighthouse)
    try:
        check, _ = checked(asked, dict(snakemake.input.items()), settings)
    except Refusal as refusal:
        check = {"ok": False, "why": str(refusal), "warnings": [], "notes": []}
        empty_folder(Path(snakemake.output[0]).parent)  # results of an earlier input
    log.info("%s", check)
    write_json(snakemake.output[0], check)
