# Files of calibrations, recordings and groups: what rules read, and how they name what they write.
# Functions only, as in common.smk; the paths of the report's captions are relative to this file.
from functools import partial

from mocap_metrology.calibration.tables import DECODED, NETWORK_TWIN, TWIN
from mocap_workflow import report as reporting
from mocap_workflow import selection


def listed(path, category, label, **more):
    """An output with its place in the report."""
    where = {"caption": "../report/caption.rst", "category": category}
    return report(path, **where, labels={"result": label}, **more)


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


def figures_of_calibration():
    """Both figures of the rule's calibration as outputs by name, with their labels in the report."""
    shown = {"calibration": "paths, residuals, pose, verdict", "track": "tracked receiver"}
    found = {}
    for name, words in shown.items():
        stem = f"<results>/calibrations/{{calibration}}/{name}"
        found[f"{name}_svg"] = listed(f"{stem}.svg", "6 Calibrations", f"{{calibration}}: {words}")
        found[f"{name}_png"] = f"{stem}.png"
    return found


# Recordings and groups.


def of_recording(file):
    """This file of the rule's recording."""
    return f"<results>/recordings/{{recording}}/{file}"


def figure_of_recording(name, label):
    """Its figure of this name as outputs, with the label that it has in the report."""
    svg = of_recording(f"{name}.svg")
    svg = listed(svg, "5 Recordings", label, subcategory="{recording}")
    return {"svg": svg, "png": of_recording(f"{name}.png")}


def of_each(file, rows, sheet=RECORDINGS):
    """This file of each recording or calibration of a selection."""
    kind = sheet.kind.KIND
    return collect(f"<results>/{kind}s/{{row.{kind}}}/{file}", row=rows)


def tables_of_group(*names):
    """Tables of the rule's group by the end of their names, each for programs and for people."""
    return [f"<results>/tables/{{group}}_{name}.{kind}" for name in names for kind in TABLE]


def tables_by_name(*names):
    """Ends of the names of tables, each for programs and for people; see `outputs_of_group`."""
    return {f"{name}_{kind}": f"{name}.{kind}" for name in names for kind in TABLE}


def outputs_of_group(tables=None, figures=None, pages=()):
    """Outputs by name: tables by the end of their names, figures by it with the labels they have in
    the report, pages as PDF and PNG."""
    found = {name: f"<results>/tables/{{group}}_{file}" for name, file in (tables or {}).items()}
    for name, label in (figures or {}).items():
        key = "" if len(figures) == 1 else f"{name}_"
        stem = f"<results>/figures/{{group}}_{name}"
        found[f"{key}svg"] = listed(f"{stem}.svg", "4 Groups", label, subcategory="{group}")
        found[f"{key}png"] = f"{stem}.png"
    for name in pages:
        for ending in ("pdf", "png"):
            found[f"{name}_{ending}"] = f"<results>/figures/{{group}}_{name}.{ending}"
    return found


# Texts of the report.


def figure_of(paper, number):
    """SVG of a figure of a paper."""
    category = f"{2 + list(captions.PAPERS).index(paper)} {captions.PAPERS[paper]}"
    path = f"<results>/figures/{paper}_fig{number:02d}.svg"
    return listed(path, category, captions.label(paper, number))


def entry(key):
    """Function of the wildcards: category, subcategory or labels of the page of a table."""
    tables = f"{config['results']}/tables"
    return lambda wildcards: reporting.entry(f"{tables}/{wildcards.table}.md")[key]


def subjects(wildcards):
    """Names of the recordings, calibrations, monitors and groups that have a page of their own."""
    recordings, calibrations = EVERY_RECORDING(wildcards), EVERY_CALIBRATION(wildcards)
    return {
        "recording": [row.name for row in recordings],
        "calibration": [row.name for row in calibrations],
        "monitor": list(MONITORS),
        "group": list(dict.fromkeys(row.group for row in [*recordings, *calibrations])),
    }


def papers(wildcards):
    """The papers of which there are recordings or calibrations."""
    found = {"skurowski": OF_SKUROWSKI, "jansen": OF_JANSEN}
    return [paper for paper, rows in found.items() if rows(wildcards)]
