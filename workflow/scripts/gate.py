"""Report verdicts and refusals, one line each; fail if anything was refused."""

from step import RESULT, step

with step(snakemake, prefix="") as log:
    import sys
    from pathlib import Path

    from mocap_metrology.common.files import read_json, write_json

    results = list(map(Path, dict.fromkeys(snakemake.input.results)))
    verdicts = [path for path in results if path.name == "verdict.json"]
    for path in verdicts if len(verdicts) <= 10 else ():  # more are in the tables
        document = read_json(path)
        log.log(
            RESULT, "recording %s is %s: %s", path.parent.name, document["word"], document["reason"]
        )
    for path in results:
        if path.name.endswith("_compare.json"):
            for words in read_json(path)["words"]:
                log.log(RESULT, "%s", words)
    refused = []  # reported last
    for path in results:
        if path.name == "monitor.json":
            document = read_json(path)
            log.log(RESULT, "%s", document["line"])
            named = [f"{one['recording']}: {one['why']}" for one in document["left_out"]]
            refused += [f"monitor {document['monitor']}, recording {words}" for words in named]
    for path in map(Path, snakemake.input.checks):
        check = read_json(path)
        what = f"{path.parent.parent.name.removesuffix('s')} {path.parent.name}"
        for warning in check.get("warnings", []):
            log.warning("%s: %s", what, warning)
        if not check["ok"]:
            refused.append(f"{what} refused: {check['why']}")
    for path in results:
        if path.name != "pose.json":
            continue
        verdict = read_json(path)["verdict"]
        if verdict["word"] == "failed":
            refused.append(f"calibration {path.parent.name} failed: {verdict['reason']}")
    for path in results:
        if path.name == "summary.html":
            log.log(RESULT, "see %s", path)
    for line in refused:
        log.error("%s", line)
    if refused:
        sys.exit(1)
    write_json(snakemake.output[0], {"checked": len(snakemake.input.checks)})
