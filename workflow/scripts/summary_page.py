"""Verdicts of recordings and calibrations, and refusals -> the page that is read first.

Twice: by itself, and as the front of the report. Names lead to figures beside both.
"""

from step import step

with step(snakemake) as log:
    import json
    from pathlib import Path

    from mocap_metrology.common.files import write_text
    from mocap_metrology.present.pages import html_page, summary

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
    found = summary.Found([*map(read, given.verdicts)], calibrations, refused, cameras)
    body = summary.body(found, lambda kind, name: params.links[kind].get(name, ""))
    write_text(snakemake.output.page, html_page.page("Summary", body))
    write_text(snakemake.output.front, html_page.fragment(body))
    log.info("%d verdicts, %d refused", len(given.verdicts) + len(calibrations), len(refused))
