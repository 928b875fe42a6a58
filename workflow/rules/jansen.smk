# Jansen et al. 2019: the paper's tables and figures, regenerated.

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
        code=source("jansen_study.py", "lighthouse"),
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
        code=source("jansen_studies.py", "lighthouse", "noise", "present"),
        settings=config["jansen_studies"],
        seed=config["seed"],
    message:
        "Studies of the claims of Jansen et al. 2019"
    script:
        "../scripts/jansen_studies.py"


rule jansen_results:
    input:
        tables=branch(OF_JANSEN, then=collect_outputs(rules.jansen_tables.output)),
        figures=branch(OF_JANSEN, then=collect_outputs(rules.jansen_figures.output)),
