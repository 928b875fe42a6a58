# Configuration, sheets, and what rules ask about them. Functions only: rules are in other files.
import json
import sys
from pathlib import Path

from mocap_workflow import alive, cameras, comparisons as compared, files, startup
from mocap_workflow import report as reporting
from mocap_workflow.faults import Faults, stop
from mocap_workflow.sources import Sources, installed

ROOT = Path(str(workflow.current_basedir)).resolve().parents[1]


# A working folder without a config of its own gets the project's.
configfile: "config/config.yaml" if Path("config/config.yaml").is_file() else f"{ROOT}/config/config.yaml"


try:
    startup.refuse_containers(workflow.deployment_settings)
    package = installed("mocap_metrology", ROOT)
    SETTINGS = startup.configuration(config, ROOT)
    config.update(SETTINGS.model_dump(mode="json"))
    twins = files.load_twins(config["twins"])
    RECORDINGS, CALIBRATIONS = startup.sheets(config, twins["twins"])
    TWINS = startup.recording_twins(RECORDINGS, twins, config["duration_s"], config["twin_form"])
    CALIBRATION_TWINS = startup.calibration_twins(CALIBRATIONS, twins)
    if alive.runs_jobs(sys.argv):
        alive.take(Path(".snakemake"))
except Faults as faults:
    stop(faults)


# Snakemake 9.27 starts another one-second timer at every look at the queue; with 165 jobs they
# keep a core busy. The limit they serve is for submissions to a cluster.
onstart:
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None


ROWS, CALIBRATION_ROWS = (
    {name: row.model_dump() for name, row in rows.items()} for rows in (RECORDINGS, CALIBRATIONS)
)


# `source("allan.py", "noise")` in the params of a rule: its scripts, and all packages they import.
source = Sources(ROOT / "workflow/scripts", package, ROOT / "requirements/requirements.txt")


pathvars:
    results=config["results"],
    logs="<results>/logs",
    benchmarks="<results>/benchmarks",


wildcard_constraints:
    recording=startup.any_of(RECORDINGS),
    calibration=startup.any_of(CALIBRATIONS),
    group=startup.any_of(row.group for row in [*RECORDINGS.values(), *CALIBRATIONS.values()]),
    target="all|recordings|calibrations|tables|figures",


# What `params:` hold of the sheets: the columns that the script reads and no other, as a job runs
# again when any of them changes. A comment or a date is often added years later.
SUBSET = ("recording", "twin", "camera_type", "n_cameras")


def columns(*names):
    """Function for `params`: these columns of the recording or calibration of the rule."""

    def of(wildcards):
        rule_row = row if hasattr(wildcards, "recording") else calibration_row
        return columns_of([rule_row(wildcards)], *names)[0]

    return of


def columns_of(rows, *names):
    """These columns of several rows."""
    return [{name: row[name] for name in names} for row in rows]


# Recordings. `recording` is a name or the wildcards of a rule, so that each serves as input function.


def recording_names(group=None):
    """Names in the order of the sheet, of one group or of all."""
    return [name for name, row in RECORDINGS.items() if group in (None, row.group)]


def row(recording):
    """The row of a recording as plain values, see mocap_workflow/recordings.py."""
    return ROWS[getattr(recording, "recording", recording)]


def twin_of(recording):
    """Name of the twin that stands in for a recording, None for a real one."""
    return row(recording)["twin"]


def twin_settings(recording):
    """Everything the twin is made of, see config/twins.yaml."""
    return TWINS[twin_of(recording)]


def form_of(recording):
    """Whether the frames of a twin are points or averages; None for a real recording."""
    return twin_settings(recording).get("form", "sampled") if is_twin(recording) else None


def is_twin(recording):
    return twin_of(recording) is not None


def inputs_of(recording):
    """The files of a recording in order; for a twin the file that simulate_recording makes."""
    name = row(recording)["recording"]
    return [f"<results>/recordings/{name}/twin.c3d"] if is_twin(name) else row(name)["paths"]


def check_of(recording):
    """The check.json of a real recording, nothing for a twin."""
    name = row(recording)["recording"]
    return [] if is_twin(name) else [f"<results>/recordings/{name}/check.json"]


def groups():
    """Groups in the order in which the sheet first names them."""
    return list(dict.fromkeys(row.group for row in RECORDINGS.values()))


# Calibrations, the same.


def calibration_names(group=None, twin=None):
    """Names in the order of the sheet, of one group or of all; twins, real ones, or both."""
    return [
        name
        for name, row in CALIBRATIONS.items()
        if group in (None, row.group) and twin in (None, bool(row.twin))
    ]


def calibration_row(calibration):
    """The row of a calibration as plain values, see mocap_workflow/calibrations.py."""
    return CALIBRATION_ROWS[getattr(calibration, "calibration", calibration)]


def records(calibrations):
    """What a table of calibrations says of each beside its pose."""
    return columns_of(map(calibration_row, calibrations), "calibration", "setup", "source")


def calibration_twin_settings(calibration):
    """Everything the twin is made of, see config/twins.yaml."""
    return CALIBRATION_TWINS[calibration_row(calibration)["twin"]]


def calibration_files(calibration):
    """What a real calibration is decoded from: recording, board, factory calibration, by name."""
    row = calibration_row(calibration)
    files = {"dump": row["path"], "factory": row["factory"]}
    if row["format"] != "libsurvive-rec":
        files["board"] = row["board"]
    return {name: path for name, path in files.items() if path}


def reference_files(calibration):
    """What the sheet compares a calibration with, by name: reference, mount, earlier pose."""
    row = calibration_row(calibration)
    files = {name: row[name] for name in ("reference", "mount")} | {"earlier": row["check_against"]}
    return {name: path for name, path in files.items() if path}


def check_of_calibration(calibration):
    """The check.json of a real calibration, nothing for a twin."""
    row = calibration_row(calibration)
    return [] if row["twin"] else [f"<results>/calibrations/{row['calibration']}/check.json"]


def calibration_groups():
    """Groups of calibrations in the order in which the sheet first names them."""
    return list(dict.fromkeys(row.group for row in CALIBRATIONS.values()))


# Acceptance. A refusal is a result: check_recording always succeeds and says so in check.json.


def calibration_checks(group=None):
    """Every check.json of calibrations."""
    return [path for name in calibration_names(group) for path in check_of_calibration(name)]


def accepted_calibrations(group=None):
    """Names of accepted calibrations; a twin is one without being checked."""
    return [
        name
        for name in calibration_names(group)
        if calibration_row(name)["twin"] or calibration_verdict(name)["ok"]
    ]


def calibration_verdict(calibration):
    """check.json of a real calibration: `ok`, `why`, `warnings`."""
    path = checkpoints.check_calibration.get(calibration=calibration).output[0]
    return json.loads(Path(path).read_text(encoding="utf-8"))


def of_calibrations(file, group=None):
    """Input function: a file of every accepted calibration of a group, or of the rule's own."""
    return lambda wildcards: [
        f"<results>/calibrations/{name}/{file}"
        for name in accepted_calibrations(group or wildcards.group)
    ]


def example_calibration():
    """The calibration that the figures of the second paper show: its first twin on a half circle,
    or just its first."""
    names = accepted_calibrations("jansen2019")
    motions = {
        name: calibration_twin_settings(name)["motion"].get("pattern")
        for name in names
        if calibration_row(name)["twin"]
    }
    return next((name for name, pattern in motions.items() if pattern == "arc"), names[0])


def of_example(file):
    """Input function: a file of the calibration that the figures show."""
    return lambda wildcards: f"<results>/calibrations/{example_calibration()}/{file}"


def checks(group=None):
    """Every check.json. Beside `accepted` in a rule's input it lets all checks run at once."""
    return [path for name in recording_names(group) for path in check_of(name)]


def verdict(recording):
    """check.json of a real recording: `ok`, `why`, `warnings`."""
    path = checkpoints.check_recording.get(recording=recording).output[0]
    return json.loads(Path(path).read_text(encoding="utf-8"))


def accepted(group=None):
    """Names of accepted recordings; a twin is one without being checked."""
    return [name for name in recording_names(group) if is_twin(name) or verdict(name)["ok"]]


def accepted_groups():
    """Groups with an accepted recording."""
    return [group for group in groups() if accepted(group)]


def accepted_rows(group):
    """Rows of the accepted recordings of a group."""
    return [row(name) for name in accepted(group)]


def of_accepted(pattern):
    """Input function: the pattern for every accepted recording, of the rule's group if it has one."""

    def paths(wildcards):
        names = accepted(getattr(wildcards, "group", None))
        return [pattern.replace("{recording}", name) for name in names]

    return paths


def of_paper(file):
    """Input function: a file of every accepted recording of the first paper's group."""
    return lambda wildcards: [
        f"<results>/recordings/{name}/{file}" for name in accepted("skurowski2019")
    ]


def of_paper_twins(file):
    """The same of the twins that stand for a row of the paper's tables of coefficients."""
    return [
        f"<results>/recordings/{name}/{file}"
        for name in recording_names("skurowski2019")
        if is_twin(name) and startup.printed(twin_settings(name), row(name))
    ]


def camera_subset(recording):
    """Camera type and number of cameras, by which the first paper names its recordings."""
    return row(recording)["camera_type"], row(recording)["n_cameras"]


def subset_of_paper(recording):
    """The same; None for a recording of another group."""
    return camera_subset(recording) if row(recording)["group"] == "skurowski2019" else None


def twins_of_paper():
    """Settings of the twins among the accepted recordings of the first paper's group, by name."""
    return {name: twin_settings(name) for name in accepted("skurowski2019") if is_twin(name)}


def full_sets_of_paper():
    """Recordings that stand for the rows of its Table 4: of the largest sound set of each type.
    If none is there, the first recording."""
    from mocap_metrology.present.skurowski.camera_tables import TABLE_4, standing_for

    rows = {name: row(name) for name in accepted("skurowski2019")}
    found = [standing_for(rows, *subset) for subset in TABLE_4.items()]
    return [name for name in found if name] or list(rows)[:1]
