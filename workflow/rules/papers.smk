# The tables and figures of both papers, regenerated, and their claims.
from dataclasses import replace

SHAKEN = accepted(lambda rows: rows[:1], CRUMP)
WITHOUT_SHOCK = accepted(lambda rows: references(rows[:1]), CRUMP)
BEFORE_REPAIR = accepted(references, REPAIRED)
TWINS_OF_PAPER = accepted(
    lambda rows: {row.name: replace(TWINS[row.twin], name=row.name) for row in rows if row.twin},
    SKUROWSKI,
)
# Twins made from the row of the paper's tables for their recording.
PRINTED = selection.printed(filter(selection.subset_of_paper, RECORDINGS.rows.values()), TWINS)

SKUROWSKI_TABLES = (*(f"table{n}" for n in (3, 4, "A1", "A2", "A3")), "white_levels", "support")


# Depends on no recording.
rule skurowski_theory:
    output:
        tables=multiext(
            "<results>/tables/",
            *(
                f"{name}.{kind}"
                for name in ("skurowski_table1", "skurowski_table2", "left_out")
                for kind in ("csv", "md")
            ),
        ),
        svg=[figure_of("skurowski", n) for n in (1, 2, 3)],
        png=[f"<results>/figures/skurowski_fig{n:02d}.png" for n in (1, 2, 3)],
    log:
        "<logs>/skurowski_theory.log",
    resources:
        **cost(1000, 10),
    params:
        code=source("skurowski_theory.py"),
        caption=captions.of_figures("skurowski", 1, 2, 3),
    message:
        "Tables 1 and 2 and Figures 1-3 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_theory.py"


# Result of S's estimator for the published noise without sampling errors. Depends on no recording.
rule expected_noise:
    output:
        of_each("expected.csv", PRINTED),
    log:
        "<logs>/expected_noise.log",
    resources:
        **cost(1000, 60),
    params:
        code=source("expected_noise.py"),
        subsets={row.name: selection.subset(row) for row in PRINTED},
        twins={row.name: TWINS[row.twin] for row in PRINTED},
        forms={row.name: selection.form(row, TWINS) for row in PRINTED},
        settings=settings(*NOISE),
    message:
        "Expected noise coefficients of the recordings of Skurowski & Pawlyta 2019"
    script:
        "../scripts/expected_noise.py"


rule skurowski:
    input:
        checks=checks(RECORDINGS, SKUROWSKI),
        gaussian=of_each("gaussian.csv", OF_SKUROWSKI),
        noise=of_each("noise.csv", OF_SKUROWSKI),
        expected=of_each("expected.csv", PRINTED),
        allan=of_each("allan.parquet", OF_SKUROWSKI),
        psd=of_each("psd.parquet", OF_SKUROWSKI),
        clean=of_each("clean.parquet", accepted(selection.full_sets, SKUROWSKI)),
    output:
        collect("<results>/tables/skurowski_{table}.{kind}", table=SKUROWSKI_TABLES, kind=TABLE),
        [figure_of("skurowski", n) for n in (6, *range(9, 18))],
        [f"<results>/figures/skurowski_fig{n:02d}.png" for n in (6, *range(9, 18))],
    log:
        "<logs>/skurowski.log",
    resources:
        **cost(2000, 30),
    params:
        code=source("skurowski.py"),
        caption=captions.of_figures("skurowski", 6, *range(9, 18)),
        rows=columns(*SUBSET, "camera_ids", of=OF_SKUROWSKI),
        twins=TWINS_OF_PAPER,
        settings=settings(*NOISE, "duration_s", "twin_form"),
    message:
        "Tables 3, 4, A1-A3 and Figures 6 and 9-17 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski.py"


# Recordings beside others: with a shock, with a failing camera, after the repair.
CASES = {
    "07": SHAKEN,
    "08": accepted(selection.with_and_without_failing, SKUROWSKI),
    "A1": OF_REPAIRED,
}
OF_CASE = by_wildcard("number", CASES)
BESIDE_IT = by_wildcard("number", {"07": WITHOUT_SHOCK, "A1": BEFORE_REPAIR})
SHOCKED = by_wildcard("number", {"07": SHAKEN})


rule skurowski_case:
    input:
        checks=checks(RECORDINGS, f"{SKUROWSKI} or {CRUMP} or {REPAIRED}"),
        allan=of_each("allan.parquet", together(OF_CASE, BESIDE_IT)),
        raw=of_each("trajectories.parquet", SHOCKED),
        clean=of_each("clean.parquet", SHOCKED),
    output:
        report(
            "<results>/figures/skurowski_fig{number}.svg",
            caption="../report/caption.rst",
            category="2 Skurowski & Pawlyta 2019",
            labels=lambda wildcards: {"result": captions.label("skurowski", wildcards.number)},
        ),
        "<results>/figures/skurowski_fig{number}.png",
    log:
        "<logs>/skurowski_case/{number}.log",
    wildcard_constraints:
        number="|".join(CASES),
    resources:
        **cost(2500, 10),
    params:
        code=source("skurowski_case.py"),
        caption=lambda wildcards: captions.of_figures("skurowski", wildcards.number),
        rows=columns(*SUBSET, "compare_with", "comment", of=OF_CASE),
        others=columns("recording", "twin", of=BESIDE_IT),
        crumps=column_of_twins("crump", of=OF_CASE),
        left_out=column_of_twins("without_T_c_below_s", of=OF_CASE),
    message:
        "Figure {wildcards.number} of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_case.py"


# The first tables depend on no recording; they accompany the results of both papers.
promise(
    tables=together(
        branch(
            together(OF_SKUROWSKI, OF_JANSEN),
            then=collect_outputs(rules.skurowski_theory.output.tables),
        ),
        branch(OF_SKUROWSKI, then=in_folder("tables", rules.skurowski.output)),
    ),
    figures=together(
        branch(
            OF_SKUROWSKI,
            then=collect_outputs(
                rules.skurowski_theory.output.svg, rules.skurowski_theory.output.png
            )
            + in_folder("figures", rules.skurowski.output),
        ),
        *(
            branch(rows, then=collect_outputs(rules.skurowski_case.output, number=number))
            for number, rows in CASES.items()
        ),
    ),
)


# The first calibration on a half circle, as in the paper's figures.
EXAMPLE = accepted_calibrations(partial(selection.half_circle, twins=CALIBRATION_TWINS), JANSEN)

JANSEN_FIGURES = (3, *range(5, 9))


OF_EXAMPLE = {
    "pulses": "pulses.parquet",
    "sweeps": "sweeps.parquet",
    "stations": "stations.json",
    "poses": "poses.parquet",
    "pose": "pose.json",
    "board": "board.csv",
}


# Studies of its claims, and the settings of each besides the recordings and their length.
JANSEN_STUDIES = {
    "reconstruction": ["speeds_m_s"],
    "pattern": ["patterns"],
    "distance": ["distances_m"],
    "baseline": ["baselines_m"],
    "diodes": ["diodes"],
    "lasers": ["laser_offsets_mm", "laser_distances_m"],
}


rule jansen:
    input:
        **{key: of_each(file, EXAMPLE, CALIBRATIONS) for key, file in OF_EXAMPLE.items()},
        checks=checks(CALIBRATIONS, JANSEN),
        every=of_each("pose.json", OF_JANSEN, CALIBRATIONS),
    output:
        collect("<results>/tables/jansen_table{n}.{kind}", n=(1, 2, 3), kind=TABLE),
        [figure_of("jansen", n) for n in JANSEN_FIGURES],
        [f"<results>/figures/jansen_fig{n:02d}.png" for n in JANSEN_FIGURES],
    log:
        "<logs>/jansen.log",
    resources:
        **cost(1000, 10),
    params:
        code=source("jansen.py"),
        caption=captions.of_figures("jansen", *JANSEN_FIGURES),
        rows=columns("calibration", "setup", "source", of=OF_JANSEN),
        example=columns("calibration", "twin", of=EXAMPLE),
    message:
        "Tables I-III and Figures 3 and 5-8 of Jansen et al. 2019"
    script:
        "../scripts/jansen.py"


# With the sheet config/second_generation.tsv.
OF_STATIONS = accepted_calibrations(query="group == 'jansen2019-v2'")


rule jansen_stations:
    input:
        every=of_each("pose.json", OF_STATIONS, CALIBRATIONS),
    output:
        csv="<results>/tables/jansen2019-v2_stations.csv",
        md="<results>/tables/jansen2019-v2_stations.md",
    log:
        "<logs>/jansen_stations.log",
    localrule: True
    resources:
        **cost(500, 10),
    params:
        code=source("jansen_stations.py"),
        rows=columns("calibration", "setup", "source", of=OF_STATIONS),
    message:
        "Tables I-III of Jansen et al. 2019 with second-generation stations"
    script:
        "../scripts/jansen_stations.py"


# Simulations of what the paper claims, in their own target: they take minutes of a processor.
rule jansen_study:
    output:
        "<results>/jansen_studies/{study}.csv",
    log:
        "<logs>/jansen_study/{study}.log",
    wildcard_constraints:
        study="|".join(JANSEN_STUDIES),
    resources:
        **cost(1000, 120),
    params:
        code=source("jansen_study.py"),
        settings=lambda wildcards: {
            name: config["jansen_studies"][name]
            for name in ("recordings", "duration_s", *JANSEN_STUDIES[wildcards.study])
        },
        seed=config["seed"],
    message:
        "Study of a claim of Jansen et al. 2019: {wildcards.study}"
    script:
        "../scripts/jansen_study.py"


rule jansen_studies:
    input:
        collect(rules.jansen_study.output, study=JANSEN_STUDIES),
    output:
        csv="<results>/tables/jansen_studies.csv",
        md="<results>/tables/jansen_studies.md",
        figures=collect(
            "<results>/figures/jansen_studies_{number}.{kind}",
            number=range(1, 8),
            kind=FIGURE,
        ),
    log:
        "<logs>/jansen_studies.log",
    resources:
        **cost(1000, 10),
    params:
        code=source("jansen_studies.py"),
        settings=config["jansen_studies"],
        seed=config["seed"],
    message:
        "Studies of the claims of Jansen et al. 2019"
    script:
        "../scripts/jansen_studies.py"


promise(
    tables=together(
        branch(OF_JANSEN, then=in_folder("tables", rules.jansen.output)),
        branch(OF_STATIONS, then=collect_outputs(rules.jansen_stations.output)),
    ),
    figures=branch(OF_JANSEN, then=in_folder("figures", rules.jansen.output)),
)


JANSEN_TWINS = f"{JANSEN} and {SIMULATED}"  # their motion is known
TWINS_OF_JANSEN = accepted_calibrations(query=JANSEN_TWINS)
SETUPS = accepted_calibrations(selection.first_of_setups, JANSEN_TWINS)


rule claims:
    input:
        allan=of_each("allan.parquet", OF_SKUROWSKI),
        noise=of_each("noise.csv", OF_SKUROWSKI),
        gaussian=of_each("gaussian.csv", OF_SKUROWSKI),
        shocked=of_each("clean.parquet", SHAKEN),
        repaired=of_each("noise.csv", OF_REPAIRED),
        poses=of_each("pose.json", OF_JANSEN, CALIBRATIONS),
        truth=of_each("truth.json", TWINS_OF_JANSEN, CALIBRATIONS),
        sweeps=of_each("sweeps.parquet", SETUPS, CALIBRATIONS),
        boards=of_each("board.csv", SETUPS, CALIBRATIONS),
        truth_of_first=of_each("truth.json", SETUPS, CALIBRATIONS),
    output:
        csv="<results>/tables/claims.csv",
        md="<results>/tables/claims.md",
    log:
        "<logs>/claims.log",
    resources:
        **cost(1500, 30),
    params:
        code=source("claims.py"),
        recordings=columns("recording", "source", "camera_type", "n_cameras", of=OF_SKUROWSKI),
        repaired=columns("recording", of=OF_REPAIRED),
        calibrations=columns("calibration", "setup", "source", of=OF_JANSEN),
        moved=accepted_calibrations(selection.names, JANSEN_TWINS),
        twins=TWINS_OF_PAPER,
        hampel=config["hampel"],
    message:
        "Claims of both papers"
    script:
        "../scripts/claims.py"


# Only with a recording or a calibration of a paper's group.
promise(
    tables=branch(together(OF_SKUROWSKI, OF_JANSEN), then=collect_outputs(rules.claims.output)),
)
