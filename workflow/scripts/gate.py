"""Say what was refused, one line a recording or calibration, and fail if anything was."""

from step import step

with step(snakemake, prefix="") as log:
    import json
    import sys
    from pathlib import Path

    from mocap_metrology.common.files import write_json

    refused = 0
    for path in map(Path, snakemake.input.checks):
        check = json.loads(path.read_text(encoding="utf-8"))
        what = f"{path.parent.parent.name.removesuffix('s')} {path.parent.name}"
        for warning in check.get("warnings", []):
            log.warning("%s: %s", what, warning)
        if not check["ok"]:
            refused += 1
            log.error("%s refused: %s", what, check["why"])
    for path in map(Path, snakemake.input.results):
        if path.name != "pose.json":
            continue
        verdict = json.loads(path.read_text(encoding="utf-8"))["verdict"]
        if verdict["word"] == "failed":
            refused += 1
            log.error("calibration %s failed: %s", path.parent.name, verdict["reason"])
    if refused:
        sys.exit(1)
    write_json(snakemake.output[0], {"checked": len(snakemake.input.checks)})
