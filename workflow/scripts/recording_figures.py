"""Figures of one recording: verdict, Allan deviation, spectrum, trajectory, fits of each series."""

from step import step

with step(snakemake) as log:
    import json
    from pathlib import Path

    from mocap_metrology.pipeline.figures import (
        draw_allan,
        draw_fits,
        draw_psd,
        draw_trajectory,
        draw_verdict,
    )
    from mocap_metrology.pipeline.tables import Table
    from mocap_metrology.present.tables import read_noise

    files, folder = snakemake.input, Path(snakemake.output[0]).parent
    allan = Table.read(files.allan)
    draw_verdict(json.loads(Path(files.verdict).read_text("utf-8")), folder / "verdict")
    draw_allan(allan, folder / "adev")
    draw_psd(Table.read(files.psd), folder / "psd")
    draw_trajectory(Table.open(files.raw), Table.open(files.clean), folder / "trajectory")
    fits = Path(snakemake.output.fits)
    drawn = draw_fits(read_noise(files.noise), allan, Table.read(files.periodogram), fits)
    log.info("fits drawn: %s", ", ".join(drawn) or "none, as there are no coefficients")
