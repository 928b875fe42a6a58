# Configuration, sheets, and what rules ask about them. Functions only: rules are in other files.
import json
import sys
from pathlib import Path

ROOT = Path(str(workflow.current_basedir)).resolve().parents[1]
sys.path.insert(0, str(ROOT / "workflow"))

from lib import alive, files, startup
from lib.digest import Sources, installed
from lib.faults import Faults, stop


# A working folder without a config of its own gets the project's.
configfile: "config/config.yaml" if Path("config/config.yaml").is_file() else f"{ROOT}/config/config.yaml"


# MARKED FOR THE CALIBRATION RULES: while this line is not None, a row of calibrations.tsv is
# refused with it.
CALIBRATIONS_REFUSED = "Lighthouse calibration is not built yet; expected a sheet without rows"

try:
    startup.refuse_containers(workflow.deployment_settings)
    package = installed("mocap_metrology", ROOT)
    config.update(startup.configuration(config, ROOT))
    twins = files.load_twins(config["twins"])
    RECORDINGS, CALIBRATIONS = startup.sheets(config, ROOT, twins["twins"], CALIBRATIONS_REFUSED)
    TWINS = startup.recording_twins(RECORDINGS, twins, config["duration_s"])
    if alive.runs_jobs(sys.argv):
        alive.take(Path(".snakemake"))
except Faults as faults:
    stop(faults)


# Snakemake 9.27 starts another one-second timer at every look at the queue; with 165 jobs they
# keep a core busy. The limit they serve is for submissions to a cluster.
onstart:
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None


sources = Sources(ROOT / "workflow/scripts", package, ROOT / "requirements/requirements.txt")


pathvars:
    results=config["results"],
    logs="<results>/logs",
    benchmarks="<results>/benchmarks",


wildcard_constraints:
    recording=startup.any_of(RECORDINGS),
    calibration=startup.any_of(CALIBRATIONS),
    group=startup.any_of(row["group"] for row in [*RECORDINGS.values(), *CALIBRATIONS.values()]),
    target="all|recordings|calibrations|tables|figures",


def digest(script):
    """What `params: code=` holds: changes with the script and all it imports, see lib/digest.py."""
    return sources.digest(script)


# Recordings. `recording` is a name or the wildcards of a rule, so that each serves as input function.


def recording_names(group=None):
    """Names in the order of the sheet, of one group or of all."""
    return [name for name, row in RECORDINGS.items() if group in (None, row["group"])]


def row(recording):
    """The row of a recording as plain values, see lib/recordings.py."""
    return RECORDINGS[getattr(recording, "recording", recording)]


def twin_of(recording):
    """Name of the twin that stands in for a recording, None for a real one."""
    return row(recording)["twin"]


def twin_settings(recording):
    """Everything the twin is made of, see config/twins.yaml."""
    return TWINS[twin_of(recording)]


def is_twin(recording):
    return twin_of(recording) is not None


def inputs_of(recording):
    """The C3D files of a recording in order; for a twin the file that simulate_recording makes."""
    name = row(recording)["recording"]
    return [f"<results>/recordings/{name}/twin.c3d"] if is_twin(name) else row(name)["paths"]


def check_of(recording):
    """The check.json of a real recording, nothing for a twin."""
    name = row(recording)["recording"]
    return [] if is_twin(name) else [f"<results>/recordings/{name}/check.json"]


def groups():
    """Groups in the order in which the sheet first names them."""
    return list(dict.fromkeys(row["group"] for row in RECORDINGS.values()))


# Acceptance. A refusal is a result: check_recording always succeeds and says so in check.json.


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


def rows_of_accepted(wildcards):
    """Rows of the accepted recordings of the rule's group."""
    return [row(name) for name in accepted(wildcards.group)]


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


# Targets.


def wanted(target):
    """Results of a target: the entries of WANTED, filled in, or what they return when called."""
    kinds = list(WANTED) if target == "all" else [target]
    paths = []
    for entry in (entry for kind in kinds for entry in WANTED[kind]):
        if callable(entry):
            paths += entry()
        elif "{recording}" in entry:
            paths += [entry.replace("{recording}", name) for name in accepted()]
        else:
            paths += [entry.replace("{group}", group) for group in accepted_groups()]
    return paths


def paper_tables():
    """Tables of the papers: only their own groups feed them."""
    found = "skurowski2019" in accepted_groups()
    numbers = (3, 4, "A1") if found else ()  # the rule of A1 makes A2 and A3 too
    return [f"<results>/tables/skurowski_table{number}.csv" for number in numbers]


def paper_figures():
    """Figures of the papers."""
    found = "skurowski2019" in accepted_groups()
    return ["<results>/figures/skurowski_fig06.svg"] if found else []


def checks_of_target(target):
    """What has to be checked for a target; calibrations ask nothing of recordings."""
    return [] if target == "calibrations" else checks()


def gate_of(target):
    """What a target asks for: its gate, or nothing at all when the sheets are empty."""
    return [f"<results>/gate/{target}.json"] if RECORDINGS or CALIBRATIONS else []
