"""Sweeps and stations -> board poses, pose of the slave, tracked board, noise of the angles, files
of other programs, figures."""

from step import step

with step(snakemake):
    from pathlib import Path

    from mocap_metrology.calibration.figures import draw
    from mocap_metrology.calibration.pose import pose
    from mocap_metrology.calibration.sweeps import Entry
    from mocap_metrology.settings import Allan, Lighthouse

    given, folder = snakemake.params, Path(snakemake.output.pose).parent
    settings, allan = Lighthouse(**given.lighthouse), Allan(**given.allan)
    pose(Entry(**given.row), dict(snakemake.input.items()), settings, allan, folder)
    draw(folder, given.row["calibration"], None)
