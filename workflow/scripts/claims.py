"""Every claim of both papers that data can decide -> claims.csv."""

from step import step

with step(snakemake) as log:
    import math
    import time

    import numpy as np

    from mocap_metrology.common.files import read_json, read_table
    from mocap_metrology.lighthouse.assess.reference import reconstruction_errors
    from mocap_metrology.lighthouse.assess.rows import records_of
    from mocap_metrology.lighthouse.board import read_board
    from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
    from mocap_metrology.lighthouse.records import hits_of
    from mocap_metrology.noise.fit.estimates import read_noise
    from mocap_metrology.papers.claims.jansen import Calibrations
    from mocap_metrology.papers.claims.study import Regenerated
    from mocap_metrology.papers.claims.table import REPEATS, SLOW_SAMPLES, decisions
    from mocap_metrology.papers.gaussian_table import cleaning_of, realisations
    from mocap_metrology.papers.jansen import source_of
    from mocap_metrology.papers.shock import shock_effect
    from mocap_metrology.present import claims, tables
    from mocap_metrology.recording.results import Table

    params, files = snakemake.params, snakemake.input

    def of_subsets(paths, read):
        keys = [(row["camera_type"], row["n_cameras"]) for row in params.recordings]
        return {key: read(path) for key, path in zip(keys, paths, strict=True)}

    def truth_of(path):
        truth = read_json(path)
        return np.array(truth["R"]), np.array(truth["t_m"]), truth["twin"]["motion"]

    study = calibrations = shock = None
    of_repaired = zip(params.repaired, files.repaired, strict=True)
    for path in files.shocked:
        cleaned = Table.open(path)
        shock = shock_effect(dict(cleaned.with_distances()), cleaned.origin["frame_rate_hz"])
    if params.recordings:
        study = Regenerated(
            of_subsets(files.allan, lambda path: read_table(path)[0]),
            of_subsets(files.noise, read_noise),
            of_subsets(files.gaussian, lambda path: tables.read(path).to_dict("records")),
            shock,
            {row["recording"]: read_noise(path) for row, path in of_repaired},
        )
    if params.calibrations:
        records = records_of(params.calibrations, files.poses)
        motion = {
            name: truth_of(path)[2] for name, path in zip(params.moved, files.truth, strict=True)
        }
        by_way = {}
        of_first = zip(files.sweeps, files.boards, files.truth_of_first, strict=True)
        seconds = math.nan
        for sweeps, board, truth in of_first:
            hits = hits_of(read_table(sweeps)[0])
            if math.isnan(seconds):
                begun = time.perf_counter()
                simplex = CalibrationSettings(estimators=("paper",), optics=("ideal",))
                calibrate(hits, read_board(board), (None, None), simplex)
                seconds = time.perf_counter() - begun
            R, t_m, _ = truth_of(truth)
            for way, error in reconstruction_errors(hits, read_board(board), R, t_m).items():
                by_way.setdefault(way, []).append(error)
        ways = {way: np.array(errors) for way, errors in by_way.items()}
        calibrations = Calibrations(records, motion, ways, seconds)
    kinds = sorted({row["source"] for row in params.recordings})
    sources = " and ".join(kinds), source_of(calibrations.records) if calibrations else ""
    cleaning, moments = cleaning_of(params.hampel), {}
    for row in params.recordings:
        if (name := row["recording"]) in params.twins:
            drawn = realisations(params.twins[name], REPEATS, cleaning, SLOW_SAMPLES)
            moments[row["camera_type"], row["n_cameras"]] = drawn
    rows = claims.claim_rows(decisions(study, calibrations, sources, moments))
    text = claims.claims_markdown(rows)
    tables.write_with(snakemake.output.csv, rows, text, claims.COLUMNS)
    log.info("%d claims", len(rows))
