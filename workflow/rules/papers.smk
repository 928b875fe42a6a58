# The tables and figures of both papers, regenerated, and their claims.

SHAKEN = accepted(selection.first, CRUMP)
WITHOUT_SHOCK = accepted(lambda rows: references(rows[:1]), CRUMP)
BEFORE_REPAIR = accepted(references, REPAIRED)
TWINS_OF_PAPER = accepted(partial(selection.twins_by_name, twins=TWINS), SKUROWSKI)
# Twins made from the row of the paper's tables for their recording.
PRINTED = selection.printed(filter(selection.subset_of_paper, RECORDINGS.rows.values()), TWINS)

SKUROWSKI_FIGURES = {
    1: "Gaussian model",
    2: "standard error",
    3: "slopes of an Allan deviation",
    6: "weighted and ordinary least squares",
    7: "a seismic crump",
    8: "a failing camera",
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
        svg=[figure_of_skurowski(n) for n in (1, 2, 3)],
        png=[f"<results>/figures/skurowski_fig{n:02d}.png" for n in (1, 2, 3)],
    log:
        "<logs>/skurowski_theory.log",
    benchmark:
        "<benchmarks>/skurowski_theory.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("skurowski_theory.py", "noise", "papers", "present"),
        caption=captions.of_skurowski(1, 2, 3),
    message:
        "Tables 1 and 2 and Figures 1-3 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_theory.py"


rule skurowski_tables:
    input:
        checks=checks(RECORDINGS, SKUROWSKI),
        gaussian=collect("<results>/recordings/{row.recording}/gaussian.csv", row=OF_SKUROWSKI),
    output:
        multiext("<results>/tables/skurowski_table", "3.csv", "3.md", "4.csv", "4.md"),
    log:
        "<logs>/skurowski_tables.log",
    benchmark:
        "<benchmarks>/skurowski_tables.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("skurowski_tables.py", "noise", "present"),
        rows=columns(*SUBSET, "camera_ids", of=OF_SKUROWSKI),
        twins=TWINS_OF_PAPER,
        hampel=config["hampel"],
    message:
        "Tables 3 and 4 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_tables.py"


rule skurowski_gaussian_figures:
    input:
        checks=checks(RECORDINGS, SKUROWSKI),
        gaussian=collect("<results>/recordings/{row.recording}/gaussian.csv", row=OF_SKUROWSKI),
        clean=collect(
            "<results>/recordings/{row.recording}/clean.parquet",
            row=accepted(selection.full_sets, SKUROWSKI),
        ),
    output:
        [figure_of_skurowski(n) for n in (9, 10, 11)],
        [f"<results>/figures/skurowski_fig{n:02d}.png" for n in (9, 10, 11)],
    log:
        "<logs>/skurowski_gaussian_figures.log",
    benchmark:
        "<benchmarks>/skurowski_gaussian_figures.tsv"
    resources:
        mem_mb=memory(2000),
        runtime=minutes(10),
    params:
        code=source("skurowski_gaussian_figures.py", "noise", "present"),
        caption=captions.of_skurowski(9, 10, 11),
        rows=columns(*SUBSET, of=OF_SKUROWSKI),
        twins=TWINS_OF_PAPER,
    message:
        "Figures 9-11 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_gaussian_figures.py"


# Result of S's estimator for the published noise without sampling errors. Depends on no recording.
rule expected_noise:
    output:
        collect("<results>/recordings/{row.recording}/expected.csv", row=PRINTED),
    log:
        "<logs>/expected_noise.log",
    benchmark:
        "<benchmarks>/expected_noise.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(60),
    params:
        code=source("expected_noise.py", "noise"),
        subsets={row.name: selection.subset(row) for row in PRINTED},
        twins={row.name: TWINS[row.twin].made(row.twin) for row in PRINTED},
        forms={row.name: selection.form(row, TWINS) for row in PRINTED},
        settings=settings(*NOISE),
    message:
        "Expected noise coefficients of the recordings of Skurowski & Pawlyta 2019"
    script:
        "../scripts/expected_noise.py"


rule skurowski_noise:
    input:
        checks=checks(RECORDINGS, SKUROWSKI),
        noise=collect("<results>/recordings/{row.recording}/noise.csv", row=OF_SKUROWSKI),
        expected=collect("<results>/recordings/{row.recording}/expected.csv", row=PRINTED),
    output:
        multiext(
            "<results>/tables/skurowski_",
            "tableA1.csv",
            "tableA1.md",
            "tableA2.csv",
            "tableA2.md",
            "tableA3.csv",
            "tableA3.md",
            "support.csv",
            "support.md",
            "white_levels.csv",
            "white_levels.md",
        ),
    log:
        "<logs>/skurowski_noise.log",
    benchmark:
        "<benchmarks>/skurowski_noise.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("skurowski_noise.py", "noise", "papers", "present"),
        rows=columns(*SUBSET, of=OF_SKUROWSKI),
    message:
        "Tables A1-A3 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_noise.py"


rule skurowski_noise_figures:
    input:
        checks=checks(RECORDINGS, SKUROWSKI),
        noise=collect("<results>/recordings/{row.recording}/noise.csv", row=OF_SKUROWSKI),
        expected=collect("<results>/recordings/{row.recording}/expected.csv", row=PRINTED),
        allan=collect("<results>/recordings/{row.recording}/allan.parquet", row=OF_SKUROWSKI),
        psd=collect("<results>/recordings/{row.recording}/psd.parquet", row=OF_SKUROWSKI),
    output:
        [figure_of_skurowski(n) for n in (6, 14, 15, 16, 17)],
        [f"<results>/figures/skurowski_fig{n:02d}.png" for n in (6, 14, 15, 16, 17)],
    log:
        "<logs>/skurowski_noise_figures.log",
    benchmark:
        "<benchmarks>/skurowski_noise_figures.tsv"
    resources:
        mem_mb=memory(1500),
        runtime=minutes(30),
    params:
        code=source("skurowski_noise_figures.py", "noise", "papers", "present"),
        caption=captions.of_skurowski(6, 14, 15, 16, 17),
        rows=columns(*SUBSET, of=OF_SKUROWSKI),
        settings=settings(*NOISE),
    message:
        "Figures 6 and 14-17 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_noise_figures.py"


rule skurowski_crump:
    input:
        raw=collect("<results>/recordings/{row.recording}/trajectories.parquet", row=SHAKEN),
        clean=collect("<results>/recordings/{row.recording}/clean.parquet", row=SHAKEN),
        allan=collect(
            "<results>/recordings/{row.recording}/allan.parquet",
            row=together(SHAKEN, WITHOUT_SHOCK),
        ),
    output:
        figure_of_skurowski(7),
        "<results>/figures/skurowski_fig07.png",
    log:
        "<logs>/skurowski_crump.log",
    benchmark:
        "<benchmarks>/skurowski_crump.tsv"
    resources:
        mem_mb=memory(2500),
        runtime=minutes(10),
    params:
        code=source("skurowski_crump.py", "coordinates.py", "noise", "present"),
        caption=captions.of_skurowski(7),
        rows=columns("recording", "twin", of=together(SHAKEN, WITHOUT_SHOCK)),
        crumps=column_of_twins("crump", of=SHAKEN),
    message:
        "Figure 7 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_crump.py"


rule skurowski_failing:
    input:
        allan=collect(
            "<results>/recordings/{row.recording}/allan.parquet",
            row=accepted(selection.with_and_without_failing, SKUROWSKI),
        ),
    output:
        figure_of_skurowski(8),
        "<results>/figures/skurowski_fig08.png",
    log:
        "<logs>/skurowski_failing.log",
    benchmark:
        "<benchmarks>/skurowski_failing.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("skurowski_families.py", "noise", "present"),
        caption=captions.of_skurowski(8),
        rows=columns(*SUBSET, of=accepted(selection.with_and_without_failing, SKUROWSKI)),
    message:
        "Figure 8 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_families.py"


rule skurowski_families:
    input:
        checks=checks(RECORDINGS, SKUROWSKI),
        allan=collect("<results>/recordings/{row.recording}/allan.parquet", row=OF_SKUROWSKI),
    output:
        figure_of_skurowski(12),
        "<results>/figures/skurowski_fig12.png",
        figure_of_skurowski(13),
        "<results>/figures/skurowski_fig13.png",
    log:
        "<logs>/skurowski_families.log",
    benchmark:
        "<benchmarks>/skurowski_families.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("skurowski_families.py", "noise", "present"),
        caption=captions.of_skurowski(12, 13),
        rows=columns(*SUBSET, of=OF_SKUROWSKI),
    message:
        "Figures 12 and 13 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_families.py"


rule skurowski_repaired:
    input:
        checks=checks(RECORDINGS, REPAIRED),
        allan=collect(
            "<results>/recordings/{row.recording}/allan.parquet",
            row=together(OF_REPAIRED, BEFORE_REPAIR),
        ),
    output:
        report(
            "<results>/figures/skurowski_figA1.svg",
            caption="../report/caption.rst",
            category="2 Skurowski & Pawlyta 2019",
            labels={"result": "Figure A1: z1 after the repair"},
        ),
        "<results>/figures/skurowski_figA1.png",
    log:
        "<logs>/skurowski_repaired.log",
    benchmark:
        "<benchmarks>/skurowski_repaired.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("skurowski_families.py", "noise", "present"),
        caption=captions.of_skurowski("A1"),
        rows=columns(*SUBSET, "compare_with", "comment", of=OF_REPAIRED),
        others=columns("recording", "twin", of=BEFORE_REPAIR),
        left_out=column_of_twins("without_T_c_below_s", of=OF_REPAIRED),
    message:
        "Figure A1 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_families.py"


# The first tables depend on no recording; they accompany the results of both papers.
promise(
    tables=together(
        branch(
            together(OF_SKUROWSKI, OF_JANSEN),
            then=collect_outputs(rules.skurowski_theory.output.tables),
        ),
        branch(
            OF_SKUROWSKI,
            then=collect_outputs(rules.skurowski_tables.output, rules.skurowski_noise.output),
        ),
    ),
    figures=together(
        branch(
            OF_SKUROWSKI,
            then=collect_outputs(
                rules.skurowski_theory.output.svg,
                rules.skurowski_theory.output.png,
                rules.skurowski_gaussian_figures.output,
                rules.skurowski_noise_figures.output,
                rules.skurowski_families.output,
            ),
        ),
        branch(accepted(query=CRUMP), then=collect_outputs(rules.skurowski_crump.output)),
        branch(
            accepted(selection.with_and_without_failing, SKUROWSKI),
            then=collect_outputs(rules.skurowski_failing.output),
        ),
        branch(OF_REPAIRED, then=collect_outputs(rules.skurowski_repaired.output)),
    ),
)


# The first calibration on a half circle, as in the paper's figures.
EXAMPLE = accepted_calibrations(partial(selection.half_circle, twins=CALIBRATION_TWINS), JANSEN)

JANSEN_FIGURES = {
    3: "what a photodiode sees",
    5: "angles of a photodiode",
    6: "paths as both stations see them",
    7: "one path laid on the other",
    8: "pose of the slave",
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


rule jansen_tables:
    input:
        checks=checks(CALIBRATIONS, JANSEN),
        poses=collect("<results>/calibrations/{row.calibration}/pose.json", row=OF_JANSEN),
    output:
        multiext(
            "<results>/tables/jansen_table",
            *(f"{n}.{kind}" for n in (1, 2, 3) for kind in ("csv", "md")),
        ),
    log:
        "<logs>/jansen_tables.log",
    benchmark:
        "<benchmarks>/jansen_tables.tsv"
    resources:
        mem_mb=memory(500),
        runtime=minutes(10),
    params:
        code=source("jansen_tables.py", "calibration_records.py", "lighthouse", "present"),
        rows=columns("calibration", "setup", "source", of=OF_JANSEN),
    message:
        "Tables I-III of Jansen et al. 2019"
    script:
        "../scripts/jansen_tables.py"


rule jansen_figures:
    input:
        checks=checks(CALIBRATIONS, JANSEN),
        pulses=collect("<results>/calibrations/{row.calibration}/pulses.parquet", row=EXAMPLE),
        sweeps=collect("<results>/calibrations/{row.calibration}/sweeps.parquet", row=EXAMPLE),
        stations=collect("<results>/calibrations/{row.calibration}/stations.json", row=EXAMPLE),
        poses=collect("<results>/calibrations/{row.calibration}/poses.parquet", row=EXAMPLE),
        pose=collect("<results>/calibrations/{row.calibration}/pose.json", row=EXAMPLE),
        board=collect("<results>/calibrations/{row.calibration}/board.csv", row=EXAMPLE),
    output:
        [
            report(
                f"<results>/figures/jansen_fig{n:02d}.svg",
                caption="../report/caption.rst",
                category="3 Jansen et al. 2019",
                labels={"result": f"Figure {n:2d}: {shows}"},
            )
            for n, shows in JANSEN_FIGURES.items()
        ],
        [f"<results>/figures/jansen_fig{n:02d}.png" for n in JANSEN_FIGURES],
    log:
        "<logs>/jansen_figures.log",
    benchmark:
        "<benchmarks>/jansen_figures.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("jansen_figures.py", "lighthouse", "present"),
        caption=captions.of_jansen(*JANSEN_FIGURES),
        rows=columns("calibration", "twin", of=EXAMPLE),
    message:
        "Figures 3 and 5-8 of Jansen et al. 2019"
    script:
        "../scripts/jansen_figures.py"


# Simulations of what the paper claims, in their own target: they take minutes of a processor.
rule jansen_study:
    output:
        "<results>/jansen_studies/{study}.csv",
    log:
        "<logs>/jansen_study/{study}.log",
    benchmark:
        "<benchmarks>/jansen_study/{study}.tsv"
    wildcard_constraints:
        study="|".join(JANSEN_STUDIES),
    resources:
        mem_mb=memory(1000),
        runtime=minutes(120),
    params:
        code=source("jansen_study.py", "lighthouse", "papers"),
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
    benchmark:
        "<benchmarks>/jansen_studies.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("jansen_studies.py", "lighthouse", "noise", "papers", "present"),
        settings=config["jansen_studies"],
        seed=config["seed"],
    message:
        "Studies of the claims of Jansen et al. 2019"
    script:
        "../scripts/jansen_studies.py"


promise(
    tables=branch(OF_JANSEN, then=collect_outputs(rules.jansen_tables.output)),
    figures=branch(OF_JANSEN, then=collect_outputs(rules.jansen_figures.output)),
)


JANSEN_TWINS = f"{JANSEN} and {SIMULATED}"  # their motion is known
TWINS_OF_JANSEN = accepted_calibrations(query=JANSEN_TWINS)
SETUPS = accepted_calibrations(selection.first_of_setups, JANSEN_TWINS)


rule claims:
    input:
        allan=collect("<results>/recordings/{row.recording}/allan.parquet", row=OF_SKUROWSKI),
        noise=collect("<results>/recordings/{row.recording}/noise.csv", row=OF_SKUROWSKI),
        gaussian=collect("<results>/recordings/{row.recording}/gaussian.csv", row=OF_SKUROWSKI),
        shocked=collect("<results>/recordings/{row.recording}/clean.parquet", row=SHAKEN),
        repaired=collect("<results>/recordings/{row.recording}/noise.csv", row=OF_REPAIRED),
        poses=collect("<results>/calibrations/{row.calibration}/pose.json", row=OF_JANSEN),
        truth=collect("<results>/calibrations/{row.calibration}/truth.json", row=TWINS_OF_JANSEN),
        sweeps=collect("<results>/calibrations/{row.calibration}/sweeps.parquet", row=SETUPS),
        boards=collect("<results>/calibrations/{row.calibration}/board.csv", row=SETUPS),
        truth_of_first=collect("<results>/calibrations/{row.calibration}/truth.json", row=SETUPS),
    output:
        csv="<results>/tables/claims.csv",
        md="<results>/tables/claims.md",
    log:
        "<logs>/claims.log",
    benchmark:
        "<benchmarks>/claims.tsv"
    resources:
        mem_mb=memory(1500),
        runtime=minutes(30),
    params:
        code=source(
            "claims.py",
            "calibration_records.py",
            "coordinates.py",
            "noise",
            "lighthouse",
            "present",
        ),
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
