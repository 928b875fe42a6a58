# Configuration, sheets and selections of rows. Functions only: rules are in other files.
import json
import operator
import sys
from dataclasses import asdict, is_dataclass
from functools import cache, partial
from pathlib import Path

from snakemake.exceptions import WorkflowError

from mocap_metrology.calibration.tables import BAR as BAR_OF_CALIBRATION
from mocap_metrology.calibration.tables import DECODED, ESTIMATED, RECEIVER
from mocap_metrology.present.text import captions
from mocap_workflow import forks, given, needs, remote, runs, selection, startup
from mocap_workflow import report as reporting
from mocap_workflow.calibrations import CalibrationRow
from mocap_metrology.common.entries import load_twins
from mocap_metrology.common.faults import Faults, stop
from mocap_workflow.recordings import RecordingRow
from mocap_workflow.sources import Sources, installed

ROOT = Path(str(workflow.current_basedir)).resolve().parents[1]


# A working folder without a config of its own gets the project's.
OWN = "config/config.yaml" if Path("config/config.yaml").is_file() else f"{ROOT}/config/config.yaml"
try:
    startup.check_python(sys.executable)
    startup.check_files([*workflow.configfiles, OWN])
except Faults as faults:
    stop(faults)


configfile: OWN


try:
    package = installed("mocap_metrology", ROOT)
    SETTINGS = startup.configuration(config, ROOT)
    config.update(SETTINGS.model_dump(mode="json"))
    twins = load_twins(config["twins"])
    recordings, calibrations = startup.sheets(config, twins["twins"])
    MONITORS = startup.monitors(config["recordings"])
    if workflow.is_main_process:  # once, not in each job
        startup.missing_markers(recordings.values())
    TWINS = startup.recording_twins(recordings, twins, config["duration_s"], config["twin_form"])
    CALIBRATION_TWINS = startup.calibration_twins(calibrations, twins)
except Faults as faults:
    stop(faults)


def checking(row):
    """Name of the checkpoint that checks a row."""
    if row.KIND == "calibration":
        return "sweeps"
    return "take_bar" if row.bar else "clean"


def beside(check):
    """Files that the checkpoint of a check writes with it."""
    kind, name = check.parts[-3:-1]
    row = {"recordings": recordings, "calibrations": calibrations}.get(kind, {}).get(name)
    if row is None or row.twin:
        return []
    return [Path(path).name for path in getattr(rules, checking(row)).output]


# Clears what a killed run left in the folder of results.
runs.claims(workflow, Path(config["results"]), beside)
reporting.without_markup()
if not workflow.is_main_process:  # a job of a cluster does its work itself
    forks.refuse()


onstart:
    runs.without_rate_limit(workflow.scheduler)
    forks.serve(len(list(workflow.dag.needrun_jobs())))


CONTENTS = given.contents(
    path for row in [*recordings.values(), *calibrations.values()] for path in selection.files(row)
)
RECORDINGS = selection.Sheet(RecordingRow, recordings)
CALIBRATIONS = selection.Sheet(CalibrationRow, calibrations)


# `source("allan.py", "noise")` in the params of a rule: its scripts, and all packages they import.
source = Sources(ROOT / "workflow/scripts", package, ROOT / "requirements/requirements.txt")

# What determines the estimates of noise.
NOISE = ("noise", "annealing", "allan", "hampel", "seed")


pathvars:
    results=config["results"],
    logs="<results>/logs",


wildcard_constraints:
    recording=selection.any_of(RECORDINGS.rows),
    calibration=selection.any_of(CALIBRATIONS.rows),
    setup=selection.any_of({row.setup for row in CALIBRATIONS.rows.values()}),
    monitor=selection.any_of(MONITORS),
    group=selection.any_of([*RECORDINGS.groups, *CALIBRATIONS.groups]),
    target="all|recordings|calibrations|tables|figures",


# Queries of a sheet, for `lookup` and `accepted`.
OF_GROUP = "group == '{group}'"  # of the rule's wildcard
EVERY = "index >= 0"
ABOUT_NOISE = "about == 'noise'"  # recordings at rest
ABOUT_BAR = "about == 'bar'"  # of a bar that is moved
NOISE_OF_GROUP = f"{OF_GROUP} and {ABOUT_NOISE}"
SIMULATED = "source == 'twin'"
MEASURED = "source == 'measured'"
SKUROWSKI = f"group == 'skurowski2019' and {ABOUT_NOISE}"
CRUMP = f"group == 'skurowski2019-crump' and {ABOUT_NOISE}"
REPAIRED = f"group == 'skurowski2019-repaired' and {ABOUT_NOISE}"
JANSEN = "group == 'jansen2019'"

# Columns of a recording that most tables and figures show; see `columns`.
SUBSET = ("recording", "twin", "camera_type", "n_cameras")

# File endings: for programs and for people.
TABLE, FIGURE = ("csv", "md"), ("svg", "png")


def settings(*sections, **keys):
    """Sections of the configuration, or of some only these keys, for `Settings` in a script."""
    some = {name: {key: config[name][key] for key in keys[name]} for name in keys}
    return {name: config[name] for name in sections} | some


NEEDS = needs.Needs(recordings, TWINS)


def cost(mb, count, arrays=0, seconds=0):
    """Resources of a job, see `Needs`."""
    return {"mem_mb": NEEDS.memory(mb, arrays), "runtime": NEEDS.minutes(count, seconds)}


# Values of the rule's own row of a sheet.


def of_row(ask):
    """What `ask` returns for the row of the recording or calibration."""

    def of(wildcards):
        if "recording" in wildcards.keys():
            return ask(RECORDINGS.rows[wildcards.recording])
        return ask(CALIBRATIONS.rows[wildcards.calibration])

    return of


def cell(*columns):
    """One column of the row, or several as a tuple."""
    return of_row(operator.attrgetter(*columns))


def located(path):
    """A file of a sheet as the input of a rule: Snakemake retrieves it where it is in S3."""
    return storage.s3(path) if remote.in_s3(path) else path


def files(ask):
    """Function of the wildcards: the files that `ask` returns for the row, by name or as a list."""

    def of(row):
        found = ask(row)
        if isinstance(found, dict):
            return {name: located(path) for name, path in found.items()}
        return list(map(located, found))

    return of_row(of)


# Acceptance. A refusal is a result: a check always succeeds, and check.json states the reason.


@cache
def verdict(kind, name):
    """check.json of a real recording or calibration: `ok`, `why`, `warnings`."""
    row = {"recording": recordings, "calibration": calibrations}[kind][name]
    job = getattr(checkpoints, checking(row)).get(**{kind: name})
    try:
        return json.loads(Path(job.output.check).read_text(encoding="utf-8"))
    except ValueError:
        raise WorkflowError(f"{job.output.check} is damaged; the next run makes it anew") from None


def is_accepted(row):
    """A twin is, without being checked."""
    return row.twin is not None or verdict(row.KIND, row.name)["ok"]


def accepted(choose=list, query=OF_GROUP, sheet=RECORDINGS):
    """Function of the wildcards: the accepted rows that the query selects, or what `choose` makes
    of them."""
    select = lookup(query=query, within=sheet.table, cols=sheet.kind.KIND)

    def of(wildcards):
        names = select(wildcards) if callable(select) else select
        return choose([row for row in map(sheet.rows.get, names) if is_accepted(row)])

    return of


accepted_calibrations = partial(accepted, sheet=CALIBRATIONS)


# Selections of several subjects.
EVERY_RECORDING = accepted(query=EVERY)
AT_REST = accepted(query=ABOUT_NOISE)
EVERY_CALIBRATION = accepted_calibrations(query=EVERY)
OF_SKUROWSKI = accepted(query=SKUROWSKI)
OF_REPAIRED = accepted(query=REPAIRED)
OF_JANSEN = accepted_calibrations(query=JANSEN)


def groups(choose=list, query=EVERY, sheet=RECORDINGS):
    """Function of the wildcards: groups of whose accepted rows `choose` selects some."""
    every = accepted(query=query, sheet=sheet)

    def of(wildcards):
        rows = {}
        for row in every(wildcards):
            rows.setdefault(row.group, []).append(row)
        return [group for group in rows if choose(rows[group])]

    return of


# Values of `choose`, besides functions of mocap_workflow/selection.py.


def pairs(rows):
    """Names of recordings and of their references, see mocap_workflow/selection.py."""
    return selection.pairs(rows, [row.name for row in AT_REST(None)])


def references(rows):
    """The accepted recordings that these are compared with."""
    return selection.references(rows, AT_REST(None))


def has_bodies(row):
    """Whether a label that was chosen is a body, with an orientation beside its position."""
    return not row.twin and bool(verdict("recording", row.name).get("bodies"))


def takes_of(wildcards):
    """Accepted takes of the rule's monitor, in order of the sheet."""
    rows = [RECORDINGS.rows[take.recording] for take in MONITORS[wildcards.monitor]]
    return [row for row in rows if is_accepted(row)]


def turned(rows):
    """Names of recordings with an orientation: of a cluster of markers or of a body."""
    return [row.name for row in rows if row.cluster or has_bodies(row)]


def moved(rows):
    """Names of real recordings of a pair that moves."""
    names = [row.name for row in rows if not row.twin and len(row.markers) > 1]
    return [name for name in names if verdict("recording", name).get("moving")]


# `params:` contain only the columns of the sheets that the script reads, because a job runs again
# when one of them changes. A comment or a date is often added years later.


def asked(ask, of):
    """Function of the wildcards: what `ask` returns for the rule's row, or for each row `of` a
    selection."""
    return of_row(ask) if of is None else lambda wildcards: list(map(ask, of(wildcards)))


def columns(*names, of=None):
    """These columns, see `asked`."""
    return asked(lambda row: {name: getattr(row, name) for name in names}, of)


def contents(files, of=None):
    """Hashes of those files that `files` returns by name or as a list, see `asked`. Snakemake itself
    does not notice a file with an older date."""

    def hashes(row):
        found = files(row)
        return list(map(CONTENTS.get, found.values() if isinstance(found, dict) else found))

    return asked(hashes, of)


def column(name, of):
    """Function of the wildcards: this column of the rows of a selection, by their names."""
    return lambda wildcards: {row.name: getattr(row, name) for row in of(wildcards)}


def twin_of(twins):
    """Function of the wildcards: the twin of the row by its name, see config/twins.yaml. In a dict,
    as Snakemake sees no change in a value of a class that it does not know."""
    return of_row(lambda row: {row.twin: selection.on_its_date(twins[row.twin], row)})


def column_of_twins(setting, of):
    """Function of the wildcards: a setting of the twins among some recordings that have it, in
    plain values."""

    def values(wildcards):
        twins = [TWINS[row.twin] for row in of(wildcards) if row.twin]
        found = [getattr(twin, setting, None) for twin in twins]
        return [asdict(one) if is_dataclass(one) else one for one in found if one]

    return values


# Targets. Every file of rules names its outputs by target.

PROMISED = {target: [] for target in ("recordings", "calibrations", "tables", "figures", "pages")}


def promise(**outputs):
    """Add outputs to targets: lists, or functions of the wildcards that return them."""
    for target, files in outputs.items():
        PROMISED[target].append(files)


def together(*parts):
    """Function of the wildcards: what is in the lists, and what the functions return."""

    def of(wildcards):
        lists = [part(wildcards) if callable(part) else part for part in parts]
        return [item for found in lists for item in found]

    return of


def collect_outputs(*outputs, **wildcards):
    """All files that are outputs of some rules, for all values of their wildcards. `collect` alone
    refuses outputs that are marked for the report."""
    return collect([str(path) for paths in outputs for path in paths], **wildcards)


def in_folder(name, outputs):
    """Those outputs of a rule that are in the folder of this name."""
    return [path for path in collect_outputs(outputs) if Path(path).parent.name == name]


def by_wildcard(name, choices):
    """Function of the wildcards: what that of the choices returns which a wildcard names."""

    def of(wildcards):
        choose = choices.get(wildcards[name])
        return choose(wildcards) if choose else []

    return of


def results_of(*targets):
    """Function of the wildcards: what has been promised for these targets."""
    return lambda wildcards: together(*(part for t in targets for part in PROMISED[t]))(wildcards)


def gate(target):
    """Inputs of a target: its gate, or nothing when the sheets are empty."""
    return [f"<results>/gate/{target}.json"] if RECORDINGS.rows or CALIBRATIONS.rows else []


def checks(sheet, query=EVERY):
    """check.json of the real recordings or calibrations that the query selects. Beside `accepted`
    in a rule's input it lets all checks run at once."""
    kind = sheet.kind.KIND
    names = lookup(query=f"({query}) and {MEASURED}", within=sheet.table, cols=kind)
    return collect(f"<results>/{kind}s/{{name}}/check.json", name=names)
