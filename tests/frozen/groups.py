"""What several recordings or calibrations say together, and readings of real files."""

import json
import logging
from pathlib import Path

import numpy as np
import pandas as pd
from mocap_workflow.recording_twins import recording_twin
from scipy.spatial.transform import Rotation

from mocap_metrology.calibration.pose import simulate
from mocap_metrology.calibration.setup import Member, write_setup
from mocap_metrology.calibration.sweeps import Entry as Calibration
from mocap_metrology.calibration.tables import TABLES
from mocap_metrology.common.entries import load_twins
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import read_table
from mocap_metrology.io.read import labels_of, read_recording
from mocap_metrology.lighthouse.decode.chain import decode
from mocap_metrology.noise.cameras.take import Take, levels_of, one_frame, take_rows
from mocap_metrology.noise.changes.covariate import Covariate, coherence_row
from mocap_metrology.noise.changes.rows import coarse_steps, compare_rows, places_rows, trend_rows
from mocap_metrology.noise.filters import body_covariance
from mocap_metrology.noise.fit.estimates import read_noise
from mocap_metrology.noise.motion.orientation import of_cluster, of_poses
from mocap_metrology.noise.motion.place import by_place, evenness
from mocap_metrology.recording.clean import Entry, simulated
from mocap_metrology.settings import Lighthouse, Settings

from .calibrations import LIGHT, ROOT, first_generation, twin
from .digest import Flat, flat, of_folder
from .recordings import SETTINGS, START, steps

WHITE_ALONE = {"estimators": ("likelihood",), "max_gauss_markov": 0, "sinusoid": False}


def taken(
    names: dict[str, dict],
    folder: Path,
    judged: set[str],
    others: Settings = SETTINGS,
    **changes: object,
) -> None:
    """Twins through the steps of a recording, each in a folder of its name; those whose folder no
    case reads as a whole are not judged, and have settings of their own."""
    twins = load_twins(str(ROOT / "config/twins.yaml"))
    defaults = twins["defaults"]["recording"]
    for name, own in names.items():
        twin = recording_twin(twins["twins"][own.pop("like", name)] | own | changes, name, defaults)
        with simulated(twin, 0, folder) as path:
            entry = Entry([str(path)], twin.labels)
            origin = {"recording": name, "source": "simulated"}
            settings = SETTINGS if name in judged else others
            steps(folder / name, entry, origin, settings, name in judged)


def cameras(folder: Path) -> Flat:
    """Subsets of the cameras of one take, one of which fails."""
    names = [f"hall-{n}" for n in (6, 7, 8)]
    taken({name: {} for name in names}, folder, {"hall-6"}, duration_s=40)
    twins = load_twins(str(ROOT / "config/twins.yaml"))["twins"]
    ids = {name: twins[name]["camera_ids"] for name in names}
    take = Take({n: folder / n / "trajectories.parquet" for n in names}, 6.0, 1.0)
    sigma = {n: one_frame(pd.read_csv(folder / n / "covariance.csv")) for n in names}
    noise = {n: read_noise(folder / n / "noise.csv") for n in names}
    log = logging.getLogger("frozen")
    rows, laws = take_rows("Vantage", ids, take, sigma, noise, 0.1, log)
    found = {"rows": rows, "laws": laws, "levels": levels_of(ids, sigma)}
    return of_folder(folder / "hall-6") | dict(flat(found))


def changes(folder: Path) -> Flat:
    """Recordings of S's twins against each other: pairs, dates, places, a covariate."""
    kinds = {"T40-10": {}, "Bonita-6": {}, "T40-10-crump": {}, "outliers": {}}
    others = Settings(noise=WHITE_ALONE)  # of which Allan deviations alone are read
    taken(kinds | {"rounded": {}}, folder, {"T40-10", "outliers"}, others, duration_s=60)
    allan = {name: read_table(folder / name / "allan_masked.parquet") for name in [*kinds]}
    columns, origins = ({n: pair[k] for n, pair in allan.items()} for k in (0, 1))
    first = columns["T40-10"]
    coarse = coarse_steps(*(read_table(folder / "rounded/allan_masked.parquet")[0], 0.01))
    found = {"coarse": coarse, "origins": origins}
    for name in list(kinds)[1:]:
        how = {"margin": 0.1, "alpha": 0.05, "confidence": 0.95}
        found[name] = compare_rows(name, "T40-10", columns[name], first, **how, coarse=coarse)
    names, dates = list(kinds), ["2026-01-02", "2026-01-09", "2026-02-01", "2026-03-08"]
    found["trend"] = trend_rows(names, dates, columns, 0.05, 0.95, {})
    rows = [{"recording": name, "place": name[:3]} for name in names]
    means = {name: {"x1_mm": 1.0, "y1_mm": 2.0, "z1_mm": 3.0} for name in names}
    found["places"] = places_rows(rows, columns, means)
    series = read_table(folder / "Bonita-6/clean.parquet")[0]["z1_mm"].astype(float)
    time_s = np.arange(66) * 1.0
    beside = Covariate(
        "degC", time_s, np.interp(time_s, np.arange(series.size) / 120, series) + 0.1
    )
    found["covariate"] = coherence_row(series, 120.0, beside, 0.05)
    return dict(flat(found)) | of_folder(folder / "T40-10") | of_folder(folder / "outliers")


def bodies(folder: Path) -> Flat:
    """Orientation of a cluster and of poses; noise of a length by place; levers of a body."""
    rng = np.random.default_rng(8)
    n = 4000
    turn = Rotation.from_rotvec(np.cumsum(1e-4 * rng.standard_normal((n, 3)), axis=0))
    shape = np.array([[0.0, 0, 0], [80, 0, 0], [0, 60, 0], [10, 20, 40]])
    points = turn.as_matrix() @ shape.T + 0.05 * rng.standard_normal((n, 3, 4))
    points[500:520, :, 1] = np.nan
    of = of_cluster([[points[:, a, k] for a in range(3)] for k in range(4)])
    middle = START[:3, None] + 400 * np.sin(np.arange(n) * [[2e-3], [3e-3], [1e-3]])
    length = 500 + 0.02 * rng.standard_normal(n) + middle[0] * 1e-4
    rows, visits = by_place(middle, length, 250.0)
    levers = body_covariance(shape, 0.02 + 0.01 * np.arange(12).reshape(4, 3))
    found = {"cluster": of, "poses": of_poses(turn.as_quat().T), "rows": rows, "levers": levers}
    return dict(flat(found | {"evenness": evenness(rows, visits)}))


def setup(folder: Path) -> Flat:
    """Two recordings of one pair of stations, together."""
    members, brief = [], Lighthouse(estimators=("paper-lm",))  # own poses are not read
    for name in ("real-5-1", "real-5-2"):
        own = folder / name
        own.mkdir()
        first_generation(name, own, brief, duration_s=2.0)
        kinds = ("sweeps", "stations", "board", "pose")
        members.append(Member(name, *(str(own / TABLES[kind]) for kind in kinds)))
    write_setup("real-5", members, LIGHT, str(folder / "setup.json"))
    return dict(flat(json.loads((folder / "setup.json").read_text())))


def against(folder: Path) -> Flat:
    """A calibration against an earlier one of its stations, and the board tracked with that."""
    name, earlier, later = "real-3-1", folder / "earlier", folder / "later"
    earlier.mkdir()
    later.mkdir()
    first_generation(name, earlier, duration_s=2.0)
    both = dict.fromkeys(("earlier", "tracked_with"), str(earlier / "pose.json"))
    made = twin(name, duration_s=2.0)
    row = Calibration(name, f"simulate:{name}", twin=name)
    simulate(row, made, 8, both, LIGHT, None, later)
    return of_folder(later)


def real_files(samples: Path, folder: str) -> Flat:
    """Every marker file of a folder of samples: what is read, or why it is refused."""
    found: Flat = {}
    for path in sorted((samples / folder).rglob("*")):
        name = path.relative_to(samples).as_posix()
        if path.suffix.lower() not in (".c3d", ".csv", ".tsv", ".trc", ".txt"):
            continue
        try:
            labels = labels_of(path)[:6]
            found |= {f"{name}: {k}": v for k, v in flat(read_recording([path], labels))}
        except Refusal as refusal:
            found[name] = str(refusal)
    return found


def real_sweeps(samples: Path, file: str, board: str) -> Flat:
    """Pulses, stations and hits of a recording by libsurvive."""
    return dict(flat(decode(samples / file, "libsurvive-rec", board)))


CASES = {f.__name__: f for f in (cameras, changes, bodies, setup, against)}
REAL = {
    **{f"files {name}": (real_files, name) for name in ("c3d", "exports")},
    "first generation": (real_sweeps, "lighthouse/libsurvive_extras/lh1_test_cal.rec.gz", "T20"),
    "second generation": (real_sweeps, "lighthouse2/index-yank-up-down.rec.gz", "T20"),
}
