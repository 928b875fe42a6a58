"""Tables in Markdown -> pages of HTML, those of both papers compared first."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import write_folder
    from mocap_metrology.present.pages import comparison, details, document

    pages = {}
    for source in map(Path, snakemake.input):
        if source.suffix == ".md":
            table = source.with_suffix(".csv")
            text = source.read_text(encoding="utf-8")
            short = comparison.of_file(table) if table.is_file() else None
            paper = comparison.paper_of(source.stem)
            up = details.paper_link(paper) if paper in snakemake.params.papers else {}
            page = document.page(text, source.stem, table.is_file(), short, up)
            pages[f"{source.stem}.html"] = page
            log.info("%s", source.name)
    write_folder(snakemake.output[0], pages)
