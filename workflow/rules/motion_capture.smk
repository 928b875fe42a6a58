# Motion capture: recording -> trajectories -> clean -> statistics of each series -> noise.


# A refusal is a result: this rule succeeds, and check.json states the reason. Twins need no check.
checkpoint check_recording:
    input:
        FILES,
    output:
        "<results>/recordings/{recording}/check.json",
    log:
        "<logs>/check_recording/{recording}.log",
    benchmark:
        "<benchmarks>/check_recording/{recording}.tsv"
    resources:
        mem_mb=memory(4000),
        runtime=minutes(30),
    params:
        code=source("check.py", "io", "noise", "pipeline", "present/text"),
        contents=contents(selection.paths),
        row=columns(
            *(
                "paths",
                "sha256",
                "markers",
                "frame_rate_hz",
                "accept_truncated",
                "unit",
                "column_names",
            )
        ),
        second_opinion=config["second_opinion"],
        still=config["still"],
        horizon_s=config["verdict"]["horizon_s"],
    message:
        "{wildcards.recording}: checking"
    script:
        "../scripts/check.py"


# Priority over further simulations, so that at most two raw twins are on the disk.
rule trajectories:
    input:
        files=FILES,
        check=ancient(CHECK),  # only its words change while the files do not
    output:
        "<results>/recordings/{recording}/trajectories.parquet",
    log:
        "<logs>/trajectories/{recording}.log",
    benchmark:
        "<benchmarks>/trajectories/{recording}.tsv"
    priority: 10
    resources:
        mem_mb=memory(1000, arrays=5),
        runtime=minutes(30, seconds=0.3),
    params:
        code=source("trajectories.py", "io", "noise", "pipeline"),
        contents=contents(selection.paths),
        # Paths, too: of the inputs Snakemake compares the set alone, and here their order counts
        row=columns(
            *("recording", "twin", "source", "paths", "markers", "pairs"),
            *("frame_rate_hz", "accept_truncated", "unit", "column_names"),
        ),
        form=of_row(partial(selection.form, twins=TWINS)),
    message:
        "{wildcards.recording}: reading"
    script:
        "../scripts/trajectories.py"


# In one job: starting Python and reading the table takes as long as each of the five.
rule series_statistics:
    input:
        "<results>/recordings/{recording}/trajectories.parquet",
    output:
        clean="<results>/recordings/{recording}/clean.parquet",
        outliers="<results>/recordings/{recording}/outliers.csv",
        allan="<results>/recordings/{recording}/allan.parquet",
        psd="<results>/recordings/{recording}/psd.parquet",
        gaussian="<results>/recordings/{recording}/gaussian.csv",
        covariance="<results>/recordings/{recording}/covariance.csv",
    log:
        "<logs>/series_statistics/{recording}.log",
    benchmark:
        "<benchmarks>/series_statistics/{recording}.tsv"
    resources:
        mem_mb=memory(1000, arrays=9),
        runtime=minutes(30, seconds=2.2),
    params:
        code=source("series_statistics.py", "noise", "pipeline"),
        hampel=config["hampel"],
        allan=config["allan"],
        psd=config["psd"],
        gaussian=config["gaussian"],
    message:
        "{wildcards.recording}: outliers, Allan deviations, spectrum, Gaussian model"
    script:
        "../scripts/series_statistics.py"


# Priority, because it is the longest job of a recording and should not run last and alone.
rule noise:
    input:
        raw="<results>/recordings/{recording}/trajectories.parquet",
        allan="<results>/recordings/{recording}/allan.parquet",
    output:
        noise="<results>/recordings/{recording}/noise.csv",
        allan="<results>/recordings/{recording}/allan_masked.parquet",
        periodogram="<results>/recordings/{recording}/periodogram.parquet",
    log:
        "<logs>/noise/{recording}.log",
    benchmark:
        "<benchmarks>/noise/{recording}.tsv"
    priority: 5
    resources:
        mem_mb=memory(1000, arrays=9),
        runtime=minutes(120, seconds=2.6),
    params:
        code=source("noise.py", "noise", "pipeline"),
        subset=of_row(selection.subset_of_paper),
        settings=NOISE_SETTINGS,
    message:
        "{wildcards.recording}: noise coefficients"
    script:
        "../scripts/noise.py"


rule motion_capture_results:
    input:
        recordings=collect_outputs(
            rules.trajectories.output,
            rules.series_statistics.output,
            rules.noise.output,
            recording=accepted(selection.names, EVERY),
        ),
