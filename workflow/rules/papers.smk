# The tables and figures of both papers, regenerated, and their claims.
from dataclasses import replace

SHAKEN = accepted(selection.first, CRUMP)
WITHOUT_SHOCK = accepted(lambda rows: references(rows[:1]), CRUMP)
BEFORE_REPAIR = accepted(references, REPAIRED)
TWINS_OF_PAPER = accepted(
    lambda rows: {row.name: replace(TWINS[row.twin], name=row.name) for row in rows if row.twin},
    SKUROWSKI,
)
# Twins made from the row of the paper's tables for their recording.
PRINTED = selection.printed(filter(selection.subset_of_paper, RECORDINGS.rows.values()), TWINS)
BOTH = together(OF_SKUROWSKI, OF_JANSEN)

SKUROWSKI_FIGURES = {
    1: "Gaussian model",
    2: "standard error",
    3: "slopes of an Allan deviation",
    6: "weighted and ordinary least squares",
    9: "positions of the markers",
    10: "the distance by sets of cameras",
    11: "spread over the number of cameras",
    12: "Allan deviation by number of cameras",
    13: "Allan deviation by camera type",
    14: "colour noise, logarithmic",
    15: "colour noise, linear",
    16: "correlated noise",
    17: "periodic disturbance",
}
SKUROWSKI_CASES = {
    "07": "Figure  7: a seismic crump",
    "08": "Figure  8: a failing camera",
    "A1": "Figure A1: z1 after the repair",
}
SKUROWSKI_TABLES = (*(f"table{n}" for n in (3, 4, "A1", "A2", "A3")), "white_levels", "support")


def tables_of_papers(*names):
    """Tables of these names as outputs."""
    return {"tables": collect("<results>/tables/{name}.{kind}", name=names, kind=TABLE)}


def figures_of_paper(paper, titles):
    """Figures of a paper by number as outputs, with their titles in the report."""
    category = {"skurowski": "2 Skurowski & Pawlyta 2019", "jansen": "3 Jansen et al. 2019"}[paper]
    svg = [
        listed(f"<results>/figures/{paper}_fig{n:02d}.svg", category, f"Figure {n:2d}: {title}")
        for n, title in titles.items()
    ]
    return {"svg": svg, "png": [f"<results>/figures/{paper}_fig{n:02d}.png" for n in titles]}


# Depends on no recording; its tables accompany the results of both papers.
THEORY = job(
    "skurowski_theory",
    output=tables_of_papers("skurowski_table1", "skurowski_table2", "left_out")
    | figures_of_paper("skurowski", {n: SKUROWSKI_FIGURES[n] for n in (1, 2, 3)}),
    mem_mb=memory(1000),
    params={"caption": captions.of_skurowski(1, 2, 3)},
    message="Tables 1 and 2 and Figures 1-3 of Skurowski & Pawlyta 2019",
)
promise(
    tables=branch(BOTH, then=in_folder("tables", THEORY)),
    figures=branch(OF_SKUROWSKI, then=in_folder("figures", THEORY)),
)
# Result of S's estimator for the published noise without sampling errors. Depends on no recording.
job(
    "expected_noise",
    output={"expected": of_each("expected.csv", PRINTED)},
    mem_mb=memory(1000),
    runtime=minutes(60),
    params={
        "subsets": {row.name: selection.subset(row) for row in PRINTED},
        "twins": {row.name: TWINS[row.twin] for row in PRINTED},
        "forms": {row.name: selection.form(row, TWINS) for row in PRINTED},
        "settings": settings(*NOISE),
    },
    message="Expected noise coefficients of the recordings of Skurowski & Pawlyta 2019",
)
FROM_RECORDINGS = {n: title for n, title in SKUROWSKI_FIGURES.items() if n > 3}
OF_S = job(
    "skurowski",
    input={
        "checks": checks(RECORDINGS, SKUROWSKI),
        "gaussian": of_each("gaussian.csv", OF_SKUROWSKI),
        "noise": of_each("noise.csv", OF_SKUROWSKI),
        "expected": of_each("expected.csv", PRINTED),
        "allan": of_each("allan.parquet", OF_SKUROWSKI),
        "psd": of_each("psd.parquet", OF_SKUROWSKI),
        "clean": of_each("clean.parquet", accepted(selection.full_sets, SKUROWSKI)),
    },
    output=tables_of_papers(*(f"skurowski_{name}" for name in SKUROWSKI_TABLES))
    | figures_of_paper("skurowski", FROM_RECORDINGS),
    mem_mb=memory(2000),
    runtime=minutes(30),
    params={
        "caption": captions.of_skurowski(*FROM_RECORDINGS),
        "rows": columns(*SUBSET, "camera_ids", of=OF_SKUROWSKI),
        "twins": TWINS_OF_PAPER,
        "settings": settings(*NOISE, "duration_s", "twin_form"),
    },
    message="Tables 3, 4, A1-A3 and Figures 6 and 9-17 of Skurowski & Pawlyta 2019",
)
promise(
    tables=branch(OF_SKUROWSKI, then=in_folder("tables", OF_S)),
    figures=branch(OF_SKUROWSKI, then=in_folder("figures", OF_S)),
)
# Recordings beside others: with a shock, with a failing camera, after the repair.
CASES = {
    "07": SHAKEN,
    "08": accepted(selection.with_and_without_failing, SKUROWSKI),
    "A1": OF_REPAIRED,
}
OF_CASE = by_wildcard("number", CASES)
BESIDE_IT = by_wildcard("number", {"07": WITHOUT_SHOCK, "A1": BEFORE_REPAIR})
SHOCKED = by_wildcard("number", {"07": SHAKEN})
CASE = job(
    "skurowski_case",
    of="number",
    only={"number": "|".join(CASES)},
    input={
        "checks": checks(RECORDINGS, f"{SKUROWSKI} or {CRUMP} or {REPAIRED}"),
        "allan": of_each("allan.parquet", together(OF_CASE, BESIDE_IT)),
        "raw": of_each("trajectories.parquet", SHOCKED),
        "clean": of_each("clean.parquet", SHOCKED),
    },
    output={
        "svg": report(
            "<results>/figures/skurowski_fig{number}.svg",
            caption="../report/caption.rst",
            category="2 Skurowski & Pawlyta 2019",
            labels=lambda wildcards: {"result": SKUROWSKI_CASES[wildcards.number]},
        ),
        "png": "<results>/figures/skurowski_fig{number}.png",
    },
    mem_mb=memory(2500),
    params={
        "caption": lambda wildcards: captions.of_skurowski(wildcards.number.lstrip("0")),
        "rows": columns(*SUBSET, "compare_with", "comment", of=OF_CASE),
        "others": columns("recording", "twin", of=BESIDE_IT),
        "crumps": column_of_twins("crump", of=OF_CASE),
        "left_out": column_of_twins("without_T_c_below_s", of=OF_CASE),
    },
    message="Figure {wildcards.number} of Skurowski & Pawlyta 2019",
)
for NUMBER, ROWS in CASES.items():
    promise(figures=branch(ROWS, then=collect(CASE, number=NUMBER)))

# The first calibration on a half circle, as in the paper's figures.
EXAMPLE = accepted_calibrations(partial(selection.half_circle, twins=CALIBRATION_TWINS), JANSEN)
JANSEN_FIGURES = {
    3: "what a photodiode sees",
    5: "angles of a photodiode",
    6: "paths as both stations see them",
    7: "one path laid on the other",
    8: "pose of the slave",
}
OF_EXAMPLE = ("pulses.parquet", "sweeps.parquet", "poses.parquet")
OF_EXAMPLE += ("stations.json", "pose.json", "board.csv")
JANSEN_COLUMNS = ("calibration", "setup", "source")
OF_J = job(
    "jansen",
    input={
        **{Path(file).stem: of_each(file, EXAMPLE, CALIBRATIONS) for file in OF_EXAMPLE},
        "checks": checks(CALIBRATIONS, JANSEN),
        "every": of_each("pose.json", OF_JANSEN, CALIBRATIONS),
    },
    output=tables_of_papers(*(f"jansen_table{n}" for n in (1, 2, 3)))
    | figures_of_paper("jansen", JANSEN_FIGURES),
    mem_mb=memory(1000),
    params={
        "caption": captions.of_jansen(*JANSEN_FIGURES),
        "rows": columns(*JANSEN_COLUMNS, of=OF_JANSEN),
        "example": columns("calibration", "twin", of=EXAMPLE),
    },
    message="Tables I-III and Figures 3 and 5-8 of Jansen et al. 2019",
)
promise(
    tables=branch(OF_JANSEN, then=in_folder("tables", OF_J)),
    figures=branch(OF_JANSEN, then=in_folder("figures", OF_J)),
)
# With the sheet config/second_generation.tsv.
OF_STATIONS = accepted_calibrations(query="group == 'jansen2019-v2'")
STATIONS = job(
    "jansen_stations",
    input={"every": of_each("pose.json", OF_STATIONS, CALIBRATIONS)},
    output=tables_of_papers("jansen2019-v2_stations"),
    local=True,
    params={"rows": columns(*JANSEN_COLUMNS, of=OF_STATIONS)},
    message="Tables I-III of Jansen et al. 2019 with second-generation stations",
)
promise(tables=branch(OF_STATIONS, then=STATIONS))

# Simulations of what the paper claims, in their own target: they take minutes of a processor.
# Settings of each besides the recordings and their length.
JANSEN_STUDIES = {
    "reconstruction": ["speeds_m_s"],
    "pattern": ["patterns"],
    "distance": ["distances_m"],
    "baseline": ["baselines_m"],
    "diodes": ["diodes"],
    "lasers": ["laser_offsets_mm", "laser_distances_m"],
}
STUDY = job(
    "jansen_study",
    of="study",
    only={"study": "|".join(JANSEN_STUDIES)},
    output={"csv": "<results>/jansen_studies/{study}.csv"},
    mem_mb=memory(1000),
    runtime=minutes(120),
    params={
        "settings": lambda wildcards: {
            name: config["jansen_studies"][name]
            for name in ("recordings", "duration_s", *JANSEN_STUDIES[wildcards.study])
        },
        "seed": config["seed"],
    },
    message="Study of a claim of Jansen et al. 2019: {wildcards.study}",
)
job(
    "jansen_studies",
    input={"studies": collect(STUDY, study=JANSEN_STUDIES)},
    output=tables_of_papers("jansen_studies")
    | {
        "figures": collect(
            "<results>/figures/jansen_studies_{number}.{kind}", number=range(1, 8), kind=FIGURE
        ),
    },
    mem_mb=memory(1000),
    params={"settings": config["jansen_studies"], "seed": config["seed"]},
    message="Studies of the claims of Jansen et al. 2019",
)

JANSEN_TWINS = f"{JANSEN} and {SIMULATED}"  # their motion is known
TWINS_OF_JANSEN = accepted_calibrations(query=JANSEN_TWINS)
SETUPS = accepted_calibrations(selection.first_of_setups, JANSEN_TWINS)
CLAIMS = job(
    "claims",
    input={
        "allan": of_each("allan.parquet", OF_SKUROWSKI),
        "noise": of_each("noise.csv", OF_SKUROWSKI),
        "gaussian": of_each("gaussian.csv", OF_SKUROWSKI),
        "shocked": of_each("clean.parquet", SHAKEN),
        "repaired": of_each("noise.csv", OF_REPAIRED),
        "poses": of_each("pose.json", OF_JANSEN, CALIBRATIONS),
        "truth": of_each("truth.json", TWINS_OF_JANSEN, CALIBRATIONS),
        "sweeps": of_each("sweeps.parquet", SETUPS, CALIBRATIONS),
        "boards": of_each("board.csv", SETUPS, CALIBRATIONS),
        "truth_of_first": of_each("truth.json", SETUPS, CALIBRATIONS),
    },
    output=tables_of_papers("claims"),
    mem_mb=memory(1500),
    runtime=minutes(30),
    params={
        "recordings": columns("recording", "source", "camera_type", "n_cameras", of=OF_SKUROWSKI),
        "repaired": columns("recording", of=OF_REPAIRED),
        "calibrations": columns(*JANSEN_COLUMNS, of=OF_JANSEN),
        "moved": accepted_calibrations(selection.names, JANSEN_TWINS),
        "twins": TWINS_OF_PAPER,
        "hampel": config["hampel"],
    },
    message="Claims of both papers",
)
# Only with a recording or a calibration of a paper's group.
promise(tables=branch(BOTH, then=CLAIMS))
