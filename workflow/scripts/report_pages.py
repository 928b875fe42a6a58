"""Tables in Markdown -> pages of HTML, each with its CSV inside."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from mocap_metrology.common.files import write_text
    from mocap_metrology.present.pages import html_page

    folder = Path(snakemake.output[0])
    for source in map(Path, snakemake.input):
        if source.suffix != ".md":
            continue
        text, table = source.read_text(encoding="utf-8"), source.with_suffix(".csv")
        body = html_page.body_of(text)
        if table.is_file():
            offer = f"{table.name}: all columns, all digits"
            body += html_page.download(table.name, table.read_bytes(), offer)
        page = html_page.page(html_page.title_of(text) or source.stem, body)
        write_text(folder / f"{source.stem}.html", page)
        log.info("%s", source.name)
