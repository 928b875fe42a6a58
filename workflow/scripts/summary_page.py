"""Verdicts of recordings and calibrations, and refusals -> the page that is read first.

Twice: by itself, and as the front of the report. Names lead to figures beside both.
"""

from step import step

with step(snakemake) as log:
    import json
    from pathlib import Path

    from mocap_metrology.common.files import write_text
    from mocap_metrology.present import tables
    from mocap_metrology.present.pages import details, front, summary
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.verdict.overview import overview_figure

    def read(path):
        return json.loads(Path(path).read_text(encoding="utf-8"))

    given, params = snakemake.input, snakemake.params
    refused = []
    for path in map(Path, given.checks):
        check, name = read(path), path.parent.name
        if not check["ok"]:
            kind = path.parent.parent.name.removesuffix("s")
            refused.append({"kind": kind, "name": name, "why": check["why"]})
    calibrations = [
        {"pose": read(path)} | row
        for row, path in zip(params.calibrations, given.poses, strict=True)
    ]
    groups = zip(params.cameras, given.cameras, strict=True)
    cameras = {group: read(path) for group, path in groups}
    compared_groups = zip(params.compared, given.changes, strict=True)
    changes = {group: read(path)["words"] for group, path in compared_groups}
    recordings = [*map(read, given.verdicts)]
    mine = front.own({"recording": recordings, "calibration": calibrations})["recording"]
    title = "One frame against the limits"
    picture = overview_figure(mine, title, front.source(mine))
    save(picture, snakemake.output.png)
    found = summary.Found(
        recordings,
        calibrations,
        refused,
        cameras,
        changes,
        Path(snakemake.output.png).read_bytes(),
        picture.caption,
    )
    claims = []
    for path in given.claims:
        claims = tables.read(path).fillna("").to_dict("records")
    compared = [Path(path) for path in given.compared if path.endswith(".csv")]
    papers = [
        summary.Paper(
            details.PAPERS[paper],
            details.address("paper", paper),
            details.claim_counts(details.of_paper(claims, paper)),
            details.tables_of(paper, compared),
        )
        for paper in params.papers
    ]

    def address(kind, name):
        return details.address(kind, name) if name in params.subjects[kind] else ""

    for path, part in ((snakemake.output.page, False), (snakemake.output.front, True)):
        write_text(path, summary.page(found, address, papers, params.tables, part))
    log.info("%d verdicts, %d refused", len(given.verdicts) + len(calibrations), len(refused))
