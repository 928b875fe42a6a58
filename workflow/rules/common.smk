# Configuration, sheets and selections of rows. Functions only: rules are in other files.
import json
import operator
from functools import cache, partial
from pathlib import Path

from snakemake.exceptions import WorkflowError

from mocap_metrology.calibration.tables import BAR as BAR_OF_CALIBRATION
from mocap_metrology.calibration.tables import DECODED, ESTIMATED, NETWORK_TWIN, RECEIVER, TWIN
from mocap_metrology.present.text import captions
from mocap_workflow import given, needs, remote, runs, selection, startup
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


# Clears what a killed run left in the folder of results.
runs.claims(workflow, Path(config["results"]))
reporting.without_markup()


onstart:
    runs.without_rate_limit(workflow.scheduler)


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
    benchmarks="<results>/benchmarks",


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
SIMULATED = "source == 'twin'"
MEASURED = "source == 'measured'"
SKUROWSKI = "group == 'skurowski2019'"
CRUMP = "group == 'skurowski2019-crump'"
REPAIRED = "group == 'skurowski2019-repaired'"
JANSEN = "group == 'jansen2019'"

# Columns of a recording that most tables and figures show; see `columns`.
SUBSET = ("recording", "twin", "camera_type", "n_cameras")

# File endings: for programs and for people.
TABLE, FIGURE = ("csv", "md"), ("svg", "png")


def settings(*sections, **keys):
    """Sections of the configuration, or of some only these keys, for `Settings` in a script."""
    some = {name: {key: config[name][key] for key in keys[name]} for name in keys}
    return {name: config[name] for name in sections} | some


# `mem_mb` and `runtime` of a job.
NEEDS = needs.Needs(recordings, TWINS)
memory, minutes = NEEDS.memory, NEEDS.minutes


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
    first = {"recording": "clean", "calibration": "sweeps"}[kind]
    job = getattr(checkpoints, first).get(**{kind: name})
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
    return selection.pairs(rows, [row.name for row in EVERY_RECORDING(None)])


def references(rows):
    """The accepted recordings that these are compared with."""
    return selection.references(rows, EVERY_RECORDING(None))


def has_bodies(row):
    """Whether a label that was chosen is a body, with an orientation beside its position."""
    return not row.twin and bool(verdict("recording", row.name).get("bodies"))


def has_bar(row):
    """Whether its bar is judged, not its noise at rest."""
    return bool(row.bar)


def is_measured(row):
    return row.twin is None


def bars(rows):
    """Names of recordings of a bar that is moved."""
    return selection.names(selection.with_bar(rows))


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


def columns(*names, of=None):
    """Function of the wildcards: these columns of the rule's row, or of each row of a selection."""

    def cells(row):
        return {name: getattr(row, name) for name in names}

    return of_row(cells) if of is None else lambda wildcards: list(map(cells, of(wildcards)))


def contents(files, of=None):
    """Function of the wildcards: hashes of those files that `files` returns for the rule's row, or
    for each row of a selection. Snakemake itself does not notice a file with an older date."""

    def hashes(row):
        return [CONTENTS.get(path) for path in files(row)]

    return of_row(hashes) if of is None else lambda wildcards: list(map(hashes, of(wildcards)))


def column(name, of):
    """Function of the wildcards: this column of the rows of a selection, by their names."""
    return lambda wildcards: {row.name: getattr(row, name) for row in of(wildcards)}


def twin_of(twins):
    """Function of the wildcards: the twin of the row by its name, see config/twins.yaml. In a dict,
    as Snakemake sees no change in a value of a class that it does not know."""
    return of_row(lambda row: {row.twin: twins[row.twin]})


def column_of_twins(setting, of):
    """Function of the wildcards: a setting of the twins among some recordings that have it."""
    return lambda wildcards: selection.twin_values(of(wildcards), TWINS, setting)


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


# Calibrations.

OF_SETUP = f"{OF_GROUP} and setup == '{{setup}}'"


def stations_for(row):
    """pose.json of the calibration that the row's board is tracked with, unless it is refused."""
    other = row.tracked_with_row
    if other is None or not is_accepted(CALIBRATIONS.rows[other]):
        return {}
    return {"tracked_with": f"{config['results']}/calibrations/{other}/pose.json"}


def objects_beside(row):
    """sweeps.parquet of the accepted calibrations of other objects of the row's recording."""
    names = [other.name for other in selection.beside(row, CALIBRATIONS.rows.values())]
    return {
        "beside": [
            f"{config['results']}/calibrations/{name}/{DECODED['sweeps']}"
            for name in names
            if is_accepted(CALIBRATIONS.rows[name])
        ]
    }


def entries_beside(*names):
    """Function of the wildcards: these columns of the calibrations of other objects, by name."""

    def cells(row):
        others = selection.beside(row, CALIBRATIONS.rows.values())
        return {other.name: {name: getattr(other, name) for name in names} for other in others}

    return of_row(cells)


def bar_of(row):
    """Files of a calibration whose row names a bar, and of the row of its other end, unless that is
    refused."""
    dump = {"dump": row.path} | ({"factory": row.factory} if row.factory else {})
    file = {"tracked_with": row.tracked_with_file} if row.tracked_with_file else {}
    found = {name: located(path) for name, path in (dump | file).items()} | stations_for(row)
    if row.bar_row and is_accepted(other := CALIBRATIONS.rows[row.bar_row]):
        folder = f"{config['results']}/calibrations/{other.name}"
        found["other_dump"] = located(other.path)
        found |= {f"other_{name}": f"{folder}/{file}" for name, file in DECODED.items()}
    return found


def receiver_of(row):
    """Motion capture of the receiver of a calibration, and the stations that it is tracked with."""
    file = {"tracked_with": row.tracked_with_file} if row.tracked_with_file else {}
    given = {"seen": row.receiver} | file
    return {name: located(path) for name, path in given.items()} | stations_for(row)


def other_end(row):
    """Columns of the row of the other end of a bar."""
    other = CALIBRATIONS.rows.get(row.bar_row)
    return other and {name: getattr(other, name) for name in ("calibration", "format", "board")}


# Files of what twins of either generation were made with.
TWIN_FILES = [
    (partial(selection.of_generation, twins=CALIBRATION_TWINS, generation=k), [*names.values()])
    for k, names in ((1, TWIN), (2, NETWORK_TWIN))
]


def at_rest(rows):
    """Calibrations whose board may be at rest; of twins it is known."""
    still = {name for name, twin in CALIBRATION_TWINS.items() if twin.motion.pattern == "still"}
    return [row for row in rows if row.twin is None or row.twin in still]


def setups(query=OF_GROUP):
    """Function of the wildcards: group, setup and source of the setups whose recordings are joined."""
    every = accepted_calibrations(selection.setups, query)
    return every if config["lighthouse"]["joint"] == "setup" else lambda wildcards: []


def poses_of_setups(query=OF_GROUP):
    """Function of the wildcards: their pose.json."""
    every = setups(query)
    return lambda wildcards: [
        f"{config['results']}/setups/{group}/{setup}/pose.json"
        for group, setup, _ in every(wildcards)
    ]


def against(rows):
    """Calibration, name and path of all that the sheet compares these with."""
    every = [(row.name, selection.compared_with(row) | stations_for(row)) for row in rows]
    return [(name, key, located(path)) for name, of in every for key, path in of.items()]


def tables(files):
    """Outputs by name, of the rule's calibration."""
    return {name: f"<results>/calibrations/{{calibration}}/{file}" for name, file in files.items()}


def figure_of_calibration(name, words):
    """SVG of the rule's calibration as output, with its label in the report."""
    return report(
        f"<results>/calibrations/{{calibration}}/{name}.svg",
        caption="../report/caption.rst",
        category="6 Calibrations",
        labels={"result": f"{{calibration}}: {words}"},
    )


def figures_of_calibration():
    """Both figures of the rule's calibration as outputs."""
    shown = {"calibration": "paths, residuals, pose, verdict", "track": "tracked receiver"}
    png = [f"<results>/calibrations/{{calibration}}/{name}.png" for name in shown]
    return [figure_of_calibration(name, words) for name, words in shown.items()] + png


# Recordings and groups.


def of_recording(file):
    """This file of the rule's recording."""
    return f"<results>/recordings/{{recording}}/{file}"


def figure_of_recording(name, label):
    """Its figure of this name as outputs, with the label that it has in the report."""
    svg = report(
        of_recording(f"{name}.svg"),
        caption="../report/caption.rst",
        category="5 Recordings",
        subcategory="{recording}",
        labels={"result": label},
    )
    return {"svg": svg, "png": of_recording(f"{name}.png")}


def of_each(file, rows, sheet=RECORDINGS):
    """This file of each recording or calibration of a selection."""
    kind = sheet.kind.KIND
    return collect(f"<results>/{kind}s/{{row.{kind}}}/{file}", row=rows)


def tables_of_group(*names):
    """Tables of the rule's group by the end of their names, each for programs and for people."""
    return [f"<results>/tables/{{group}}_{name}.{kind}" for name in names for kind in TABLE]


def outputs_of_group(tables=None, figures=None, pages=()):
    """Outputs by name: tables by the end of their names, figures by it with the labels they have in
    the report, pages as PDF and PNG."""
    found = {name: f"<results>/tables/{{group}}_{file}" for name, file in (tables or {}).items()}
    for name, label in (figures or {}).items():
        key = "" if len(figures) == 1 else f"{name}_"
        stem = f"<results>/figures/{{group}}_{name}"
        found[f"{key}svg"] = report(
            f"{stem}.svg",
            caption="../report/caption.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": label},
        )
        found[f"{key}png"] = f"{stem}.png"
    for name in pages:
        for ending in ("pdf", "png"):
            found[f"{name}_{ending}"] = f"<results>/figures/{{group}}_{name}.{ending}"
    return found


# Texts of the report.


def figure_of_skurowski(number):
    """SVG of a figure of the first paper."""
    return report(
        f"<results>/figures/skurowski_fig{number:02d}.svg",
        caption="../report/caption.rst",
        category="2 Skurowski & Pawlyta 2019",
        labels={"result": f"Figure {number:2d}: {SKUROWSKI_FIGURES[number]}"},
    )


def entry(key):
    """Function of the wildcards: category, subcategory or labels of the page of a table."""
    tables = f"{config['results']}/tables"
    return lambda wildcards: reporting.entry(f"{tables}/{wildcards.table}.md")[key]


def subjects(wildcards):
    """Names of the recordings, calibrations and groups that have a page of their own."""
    recordings, calibrations = EVERY_RECORDING(wildcards), EVERY_CALIBRATION(wildcards)
    return {
        "recording": [row.name for row in recordings],
        "calibration": [row.name for row in calibrations],
        "group": list(dict.fromkeys(row.group for row in [*recordings, *calibrations])),
    }


def papers(wildcards):
    """The papers of which there are recordings or calibrations."""
    found = {"skurowski": OF_SKUROWSKI, "jansen": OF_JANSEN}
    return [paper for paper, rows in found.items() if rows(wildcards)]
