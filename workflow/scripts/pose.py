"""Sweeps and stations -> board poses, pose of the slave, tracked board, noise of the angles, files
of other programs, figures."""

from step import step

with step(snakemake):
    from pathlib import Path

    from mocap_metrology.calibration.figures import draw
    from mocap_metrology.calibration.pose import pose
    from mocap_metrology.calibration.sweeps import Entry, paths_in
    from mocap_metrology.calibration.tables import DECODED
    from mocap_metrology.settings import Allan, Lighthouse

    params, folder = snakemake.params, Path(snakemake.output.pose).parent
    settings, allan = Lighthouse(**params.lighthouse), Allan(**params.allan)
    files = dict(snakemake.input.items())
    folders = [Path(path).parent for path in files.pop("beside", [])]
    beside = [(Entry(**params.beside[one.name]), paths_in(DECODED, one)) for one in folders]
    pose(Entry(**params.row), files, settings, allan, folder, beside=beside)
    draw(folder, params.row["calibration"], None)
