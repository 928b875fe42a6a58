"""Figures with their captions -> a page a recording, calibration, group and paper."""

from step import step

with step(snakemake) as log:
    import json
    from pathlib import Path

    from mocap_metrology.common.files import write_folder
    from mocap_metrology.present import tables
    from mocap_metrology.present.pages import details
    from mocap_metrology.present.verdict import words

    given, params = snakemake.input, snakemake.params
    folder = Path(snakemake.output[0])
    results, pages = folder.parent, {}
    images = [Path(path) for path in dict.fromkeys(given.results) if path.endswith(".svg")]
    csv = [Path(path) for path in dict.fromkeys(given.results) if path.endswith(".csv")]

    def write(kind, name, figures, files, **more):
        figures = details.figures_of(results, figures)
        title = details.PAPERS.get(name, name) if kind == "paper" else name
        page = details.page(title, figures, details.files_of(results, files), **more)
        pages[Path(details.address(kind, name)).relative_to(folder.name)] = page

    def group_link(row):
        where = f"../groups/{row['group']}.html"
        return {row["group"]: where} if row["group"] in params.groups else {}

    changes = {}
    for path in given.changes:
        changes |= json.loads(Path(path).read_text(encoding="utf-8"))["recordings"]

    every = {"recording": params.recordings, "calibration": params.calibrations}
    for kind, rows in every.items():
        for row in rows:
            name = row[kind]
            own = results / f"{kind}s" / name
            document = own / ("verdict.json" if kind == "recording" else "pose.json")
            found = json.loads(document.read_text(encoding="utf-8"))
            verdict = found if kind == "recording" else found["verdict"]
            lines = words.sentences(found) if kind == "recording" else [verdict["reason"]]
            lines += [changes[name]] if kind == "recording" and name in changes else []
            write(
                kind,
                name,
                [path for path in images if own in path.parents],
                [path for path in csv if own in path.parents],
                verdict=verdict["word"],
                lines=lines,
                up=group_link(row),
            )

    named = [*params.groups, *params.papers]
    for group in params.groups:
        figures, files = (details.files_named(group, named, paths) for paths in (images, csv))
        write("group", group, figures, files)
    claims = []
    for path in given.claims:
        claims = tables.read(path).fillna("").to_dict("records")
    for paper in params.papers:
        held, compared = details.of_paper(claims, paper), details.tables_of(paper, csv)
        of_claims = [{"title": "Claims", "table": details.claim_table(held)}] if held else []
        of_tables = [{"title": "Published tables", "table": details.table_of_tables(compared)}]
        write(
            "paper",
            paper,
            details.files_named(paper, named, images),
            [
                *details.files_named(paper, named, csv),
                *(path for path in csv if path.stem == "claims"),
            ],
            tables=[*of_claims, *of_tables],
        )
    write_folder(folder, pages)
    log.info("%d figures", len(images))
