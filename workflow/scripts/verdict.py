"""Results of one recording -> verdict.json, and the picture and words a lab would keep."""

from step import step

with step(snakemake) as log:
    import json
    from pathlib import Path

    import pandas as pd

    from mocap_metrology.common.files import read_metadata, read_series, read_table, write_json
    from mocap_metrology.noise.assess.checks import Thresholds
    from mocap_metrology.noise.assess.recording import Inputs, assess_recording
    from mocap_metrology.noise.assess.uncertainty import Span
    from mocap_metrology.noise.diagnosis.findings import Finding
    from mocap_metrology.present.drawing.style import save_figure
    from mocap_metrology.present.groups.group_tables import read_noise
    from mocap_metrology.present.verdict.document import verdict_document
    from mocap_metrology.present.verdict.figure import verdict_figure
    from mocap_metrology.present.verdict.words import verdict_lines

    given, files = snakemake.params, snakemake.input
    limits = dict(given.verdict)
    origin = read_metadata(files.clean)
    span = Span(
        origin["frame_rate_hz"],
        limits.pop("horizon_s"),
        limits.pop("window_s"),
        given.confidence,
        origin["resolution_mm"],
    )

    def told(paths, key):
        return [item for path in paths for item in json.loads(Path(path).read_text("utf-8"))[key]]

    found = assess_recording(
        Inputs(
            read_series(files.clean),
            origin["labels"],
            read_noise(files.noise),
            read_table(files.allan)[0],
            pd.read_csv(files.outliers).to_dict("records"),
            [Finding.of(row) for row in told([files.diagnosis], "findings")],
        ),
        span,
        Thresholds(**limits),
    )
    found = given.row | verdict_document(found, origin["source"])
    found["warnings"] = told(files.check, "warnings")
    found |= {key: told([files.diagnosis], key) for key in ("findings", "sentences")}
    write_json(snakemake.output.json, found)
    save_figure(verdict_figure(found), Path(snakemake.output.json).with_suffix(""))
    log.info("%s", "\n".join(verdict_lines(found)))
