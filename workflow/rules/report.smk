# What people look at: figures of each recording, tables of each group and of the papers.


rule recording_figures:
    input:
        raw="<results>/recordings/{recording}/trajectories.parquet",
        clean="<results>/recordings/{recording}/clean.parquet",
        allan="<results>/recordings/{recording}/allan.parquet",
        psd="<results>/recordings/{recording}/psd.parquet",
    output:
        multiext(
            "<results>/recordings/{recording}/",
            "adev.svg",
            "adev.png",
            "trajectory.svg",
            "trajectory.png",
            "psd.svg",
            "psd.png",
        ),
    log:
        "<logs>/recording_figures/{recording}.log",
    benchmark:
        "<benchmarks>/recording_figures/{recording}.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        code=digest("recording_figures.py"),
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
        code=digest("noise_figures.py"),
    message:
        "{wildcards.recording}: figures of the noise model"
    script:
        "../scripts/noise_figures.py"


rule group_tables:
    input:
        checks=lambda wildcards: checks(wildcards.group),
        gaussian=of_accepted("<results>/recordings/{recording}/gaussian.csv"),
        outliers=of_accepted("<results>/recordings/{recording}/outliers.csv"),
        allan=of_accepted("<results>/recordings/{recording}/allan.parquet"),
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
        code=digest("group_tables.py"),
        rows=rows_of_accepted,
    message:
        "{wildcards.group}: tables of the group"
    script:
        "../scripts/group_tables.py"


rule skurowski_tables:
    input:
        checks=checks("skurowski2019"),
        gaussian=lambda wildcards: [
            f"<results>/recordings/{name}/gaussian.csv" for name in accepted("skurowski2019")
        ],
    output:
        multiext(
            "<results>/tables/skurowski_table",
            "3.csv",
            "3.md",
            "4.csv",
            "4.md",
        ),
    log:
        "<logs>/skurowski_tables.log",
    benchmark:
        "<benchmarks>/skurowski_tables.tsv"
    threads: 1
    params:
        code=digest("skurowski_tables.py"),
        rows=lambda wildcards: [row(name) for name in accepted("skurowski2019")],
    message:
        "Tables 3 and 4 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_tables.py"


rule skurowski_noise:
    input:
        checks=checks("skurowski2019"),
        noise=of_paper("noise.csv"),
        expected=of_paper_twins("expected.csv"),
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
    threads: 1
    params:
        code=digest("skurowski_noise.py"),
        rows=lambda wildcards: [row(name) for name in accepted("skurowski2019")],
    message:
        "Tables A1-A3 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_noise.py"


rule skurowski_noise_figures:
    input:
        checks=checks("skurowski2019"),
        noise=of_paper("noise.csv"),
        expected=of_paper_twins("expected.csv"),
        allan=of_paper("allan.parquet"),
        psd=of_paper("psd.parquet"),
    output:
        multiext(
            "<results>/figures/skurowski_fig",
            *(f"{n:02d}.{kind}" for n in (6, 14, 15, 16, 17) for kind in ("svg", "png")),
        ),
    log:
        "<logs>/skurowski_noise_figures.log",
    benchmark:
        "<benchmarks>/skurowski_noise_figures.tsv"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        code=digest("skurowski_noise_figures.py"),
        rows=lambda wildcards: [row(name) for name in accepted("skurowski2019")],
        noise=config["noise"],
        annealing=config["annealing"],
        allan=config["allan"],
        hampel=config["hampel"],
        seed=config["seed"],
    message:
        "Figures 6 and 14-17 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_noise_figures.py"


rule calibration_figures:
    input:
        pose="<results>/calibrations/{calibration}/pose.json",
        poses="<results>/calibrations/{calibration}/poses.parquet",
        sweeps="<results>/calibrations/{calibration}/sweeps.parquet",
        stations="<results>/calibrations/{calibration}/stations.json",
        board="<results>/calibrations/{calibration}/board.csv",
    output:
        png="<results>/calibrations/{calibration}/calibration.png",
        svg="<results>/calibrations/{calibration}/calibration.svg",
    log:
        "<logs>/calibration_figures/{calibration}.log",
    benchmark:
        "<benchmarks>/calibration_figures/{calibration}.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=digest("calibration_figures.py"),
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
        code=digest("calibration_tables.py"),
        rows=lambda wildcards: [
            calibration_row(name) for name in accepted_calibrations(wildcards.group)
        ],
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
        code=digest("jansen_tables.py"),
        rows=lambda wildcards: [
            calibration_row(name) for name in accepted_calibrations("jansen2019")
        ],
    message:
        "Tables I-III of Jansen et al. 2019"
    script:
        "../scripts/jansen_tables.py"


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
        multiext(
            "<results>/figures/jansen_fig",
            *(f"{n:02d}.{kind}" for n in (3, 5, 6, 7, 8) for kind in ("svg", "png")),
        ),
    log:
        "<logs>/jansen_figures.log",
    benchmark:
        "<benchmarks>/jansen_figures.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=digest("jansen_figures.py"),
        name=lambda wildcards: example_calibration(),
        twin=lambda wildcards: calibration_row(example_calibration())["twin"],
    message:
        "Figures 3 and 5-8 of Jansen et al. 2019"
    script:
        "../scripts/jansen_figures.py"
