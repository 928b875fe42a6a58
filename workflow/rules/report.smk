# What people look at: figures of each recording, tables of each group and of the papers.


rule recording_figures:
    input:
        raw="<results>/recordings/{recording}/trajectories.parquet",
        clean="<results>/recordings/{recording}/clean.parquet",
        allan="<results>/recordings/{recording}/allan_masked.parquet",
        psd="<results>/recordings/{recording}/psd.parquet",
    output:
        report(
            "<results>/recordings/{recording}/adev.svg",
            caption="../report/recording.rst",
            category="5 Recordings",
            subcategory="{recording}",
            labels={"result": "Allan deviation: every series, with intervals"},
        ),
        report(
            "<results>/recordings/{recording}/psd.svg",
            caption="../report/recording.rst",
            category="5 Recordings",
            subcategory="{recording}",
            labels={"result": "spectrum: power spectral density of every series"},
        ),
        # In its folder only: as large as all other figures of the recording together
        "<results>/recordings/{recording}/trajectory.svg",
        multiext("<results>/recordings/{recording}/", "adev.png", "psd.png", "trajectory.png"),
    log:
        "<logs>/recording_figures/{recording}.log",
    benchmark:
        "<benchmarks>/recording_figures/{recording}.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        code=source("recording_figures.py", "coordinates.py", "noise", "present"),
    message:
        "{wildcards.recording}: figures"
    script:
        "../scripts/recording_figures.py"


rule noise_figures:
    input:
        noise="<results>/recordings/{recording}/noise.csv",
        allan="<results>/recordings/{recording}/allan_masked.parquet",
        periodogram="<results>/recordings/{recording}/periodogram.parquet",
    output:
        directory("<results>/recordings/{recording}/fit"),
    log:
        "<logs>/noise_figures/{recording}.log",
    benchmark:
        "<benchmarks>/noise_figures/{recording}.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=source("noise_figures.py", "noise", "present"),
    message:
        "{wildcards.recording}: figures of the noise model"
    script:
        "../scripts/noise_figures.py"


rule group_tables:
    input:
        checks=lambda wildcards: checks(wildcards.group),
        gaussian=of_accepted("<results>/recordings/{recording}/gaussian.csv"),
        outliers=of_accepted("<results>/recordings/{recording}/outliers.csv"),
        allan=of_accepted("<results>/recordings/{recording}/allan_masked.parquet"),
        noise=of_accepted("<results>/recordings/{recording}/noise.csv"),
    output:
        multiext(
            "<results>/tables/{group}",
            "_subsets.csv",
            "_subsets.md",
            "_gaussian.csv",
            "_gaussian.md",
            "_outliers.csv",
            "_outliers.md",
            "_allan.csv",
            "_allan.md",
            "_noise.csv",
            "_noise.md",
        ),
    log:
        "<logs>/group_tables/{group}.log",
    benchmark:
        "<benchmarks>/group_tables/{group}.tsv"
    threads: 1
    params:
        code=source("group_tables.py", "noise", "present"),
        rows=lambda wildcards: columns_of(
            accepted_rows(wildcards.group), *SUBSET, "camera_ids", "comment"
        ),
    message:
        "{wildcards.group}: tables of the group"
    script:
        "../scripts/group_tables.py"


rule calibration_figures:
    input:
        pose="<results>/calibrations/{calibration}/pose.json",
        poses="<results>/calibrations/{calibration}/poses.parquet",
        sweeps="<results>/calibrations/{calibration}/sweeps.parquet",
        stations="<results>/calibrations/{calibration}/stations.json",
        board="<results>/calibrations/{calibration}/board.csv",
    output:
        png="<results>/calibrations/{calibration}/calibration.png",
        svg=report(
            "<results>/calibrations/{calibration}/calibration.svg",
            caption="../report/calibration.rst",
            category="6 Calibrations",
            labels={"result": "{calibration}: paths, residuals, pose, verdict"},
        ),
    log:
        "<logs>/calibration_figures/{calibration}.log",
    benchmark:
        "<benchmarks>/calibration_figures/{calibration}.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=source("calibration_figures.py", "lighthouse", "present"),
        name=lambda wildcards: wildcards.calibration,
        twin=lambda wildcards: calibration_row(wildcards)["twin"],
    message:
        "{wildcards.calibration}: figure"
    script:
        "../scripts/calibration_figures.py"


rule calibration_tables:
    input:
        checks=lambda wildcards: calibration_checks(wildcards.group),
        poses=of_calibrations("pose.json"),
    output:
        multiext("<results>/tables/{group}_calibrations", ".csv", ".md"),
    log:
        "<logs>/calibration_tables/{group}.log",
    benchmark:
        "<benchmarks>/calibration_tables/{group}.tsv"
    threads: 1
    params:
        code=source(
            "calibration_tables.py", "calibration_records.py", "noise", "lighthouse", "present"
        ),
        rows=lambda wildcards: records(accepted_calibrations(wildcards.group)),
    message:
        "{wildcards.group}: table of calibrations"
    script:
        "../scripts/calibration_tables.py"


rule jansen_tables:
    input:
        checks=calibration_checks("jansen2019"),
        poses=of_calibrations("pose.json", "jansen2019"),
    output:
        multiext(
            "<results>/tables/jansen_table",
            *(f"{n}.{kind}" for n in (1, 2, 3) for kind in ("csv", "md")),
        ),
    log:
        "<logs>/jansen_tables.log",
    benchmark:
        "<benchmarks>/jansen_tables.tsv"
    threads: 1
    params:
        code=source("jansen_tables.py", "calibration_records.py", "noise", "lighthouse", "present"),
        rows=lambda wildcards: records(accepted_calibrations("jansen2019")),
    message:
        "Tables I-III of Jansen et al. 2019"
    script:
        "../scripts/jansen_tables.py"


JANSEN_FIGURES = {
    3: "what a photodiode sees",
    5: "angles of a photodiode",
    6: "paths as both stations see them",
    7: "one path laid on the other",
    8: "pose of the slave",
}


# The paper shows a half circle.
rule jansen_figures:
    input:
        checks=calibration_checks("jansen2019"),
        pulses=of_example("pulses.parquet"),
        sweeps=of_example("sweeps.parquet"),
        stations=of_example("stations.json"),
        poses=of_example("poses.parquet"),
        pose=of_example("pose.json"),
        board=of_example("board.csv"),
    output:
        [
            report(
                f"<results>/figures/jansen_fig{n:02d}.svg",
                caption="../report/jansen.rst",
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
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=source("jansen_figures.py", "lighthouse", "present"),
        name=lambda wildcards: example_calibration(),
        twin=lambda wildcards: calibration_row(example_calibration())["twin"],
    message:
        "Figures 3 and 5-8 of Jansen et al. 2019"
    script:
        "../scripts/jansen_figures.py"
