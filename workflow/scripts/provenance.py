"""Versions, configuration, checksums and run times -> provenance.json and its page."""

from step import step

with step(snakemake) as log:
    import platform
    import subprocess
    from importlib import metadata
    from pathlib import Path

    from mocap_metrology.common import files
    from mocap_metrology.present.pages import details

    sources_of, params = snakemake.input, snakemake.params

    def commit():
        """Of the repository the scripts are in; `-dirty` when files differ from it."""
        call = ["git", "-C", snakemake.scriptdir, "describe", "--always", "--dirty", "--abbrev=40"]
        try:
            answer = subprocess.run(call, capture_output=True, text=True, timeout=60)
        except (OSError, subprocess.TimeoutExpired):
            return None
        return answer.stdout.strip() or None

    def files_of(path):
        """Name and SHA-256 of the files of a recording (Parquet) or calibration (JSON)."""
        if path.endswith(".json"):
            origin = files.read_json(path)["origin"]
            return [(None if origin["twin"] else origin["source"], origin["sha256"])]
        return [(file["path"], file["sha256"]) for file in files.read_metadata(path)["segments"]]

    inputs = [
        row | {"file": file, "sha256": digest}
        for row, path in zip(params.inputs, sources_of.origins, strict=True)
        for file, digest in files_of(path)
    ]
    times = {}
    for path in sorted(Path(params.benchmarks).rglob("*.tsv")):
        top = path.parent == Path(params.benchmarks)
        step_name = path.stem if top else path.parent.name
        if (top or path.stem in params.names) and step_name not in params.pages:
            times.setdefault(step_name, []).append(path)
    document = {
        "code": {
            "version": metadata.version("mocap-metrology"),
            "commit": commit(),
            "python": platform.python_version(),
        },
        "configuration": params.configuration,
        "inputs": inputs,
        "run_times": details.run_times(times),
        "tables": {
            Path(path).name: files.sha256(path)
            for path in sorted(sources_of.tables)
            if path.endswith(".csv")
        },
        "packages": dict(
            sorted({d.name.lower(): d.version for d in metadata.distributions()}.items())
        ),
    }
    files.write_json(snakemake.output.json, document)
    files.write_text(snakemake.output.page, details.provenance_page(document))
    log.info("%d inputs, %d tables", len(inputs), len(document["tables"]))
