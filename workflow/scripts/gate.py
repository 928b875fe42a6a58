"""Say what was refused, one line a recording, and fail if anything was."""

from step import step

with step(snakemake, prefix="") as log:
    import json
    import sys
    from pathlib import Path

    from mocap_metrology.common.files import write_json

    refused = 0
    for path in map(Path, snakemake.input.checks):
        check = json.loads(path.read_text(encoding="utf-8"))
        for warning in check.get("warnings", []):
            log.warning("recording %s: %s", path.parent.name, warning)
        if not check["ok"]:
            refused += 1
            log.error("recording %s refused: %s", path.parent.name, check["why"])
    if refused:
        sys.exit(1)
    write_json(snakemake.output[0], {"checked": len(snakemake.input.checks)})
