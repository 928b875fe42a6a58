# ruff: noqa: F821
"""Every toy rule: joins texts; the check refuses `bad`, `wait` waits for a file `go`."""

from step import step

with step(snakemake) as log:
    import json
    import time
    from pathlib import Path

    files = snakemake.input.get("files", [])
    paths = [files] if isinstance(files, str) else files
    text = "".join(Path(path).read_text() for path in paths) or f"{snakemake.params.twin}\n"
    output = Path(snakemake.output[0])
    log.info("%s", snakemake.rule)
    until = time.monotonic() + 900  # an orphan ends by itself
    waits = snakemake.rule == "noise" and "wait" in text
    if waits:
        output.write_text("half\n")
    while waits and not Path("go").exists():
        Path("waiting").touch()
        time.sleep(0.1)
        if time.monotonic() > until:
            raise TimeoutError("no file go")
    if snakemake.rule == "clean":
        check = {"ok": "bad" not in text, "why": "it is bad", "warnings": []}
        if "moves" in text:
            check["warnings"] = ["marker A moves"]
        if not check["ok"]:
            for old in output.parent.glob("*.*"):
                old.unlink()
            text = ""
        output.write_text(json.dumps(check) + "\n")
        output = Path(snakemake.output.trajectories)
    output.write_text(text)
