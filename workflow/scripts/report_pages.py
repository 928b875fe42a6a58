"""Tables in Markdown -> pages of HTML, beside which their CSV lies."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import write_text
    from mocap_metrology.present.pages import document

    folder = Path(snakemake.output[0])
    for source in map(Path, snakemake.input):
        if source.suffix == ".md":
            table = source.with_suffix(".csv")
            text = source.read_text(encoding="utf-8")
            page = document.page(text, source.stem, table.is_file())
            write_text(folder / f"{source.stem}.html", page)
            log.info("%s", source.name)
