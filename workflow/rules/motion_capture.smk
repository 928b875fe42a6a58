# Motion capture: recording -> trajectories -> clean -> Allan deviations, spectrum, Gaussian model.


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
        row=columns("paths", "sha256", "markers", "frame_rate_hz", "accept_truncated", "unit"),
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
        mem_mb=memory(1000),
        runtime=minutes(30),
    params:
        code=source("trajectories.py", "io", "noise", "pipeline"),
        # Paths, too: of the inputs Snakemake compares the set alone, and here their order counts
        row=columns(
            *("recording", "twin", "source", "paths", "markers", "pairs"),
            *("frame_rate_hz", "accept_truncated", "unit"),
        ),
        form=of_row(partial(selection.form, twins=TWINS)),
    message:
        "{wildcards.recording}: reading"
    script:
        "../scripts/trajectories.py"


rule clean:
    input:
        "<results>/recordings/{recording}/trajectories.parquet",
    output:
        table="<results>/recordings/{recording}/clean.parquet",
        outliers="<results>/recordings/{recording}/outliers.csv",
    log:
        "<logs>/clean/{recording}.log",
    benchmark:
        "<benchmarks>/clean/{recording}.tsv"
    resources:
        mem_mb=memory(2000),
        runtime=minutes(30),
    params:
        code=source("clean.py", "noise", "pipeline"),
        hampel=config["hampel"],
    message:
        "{wildcards.recording}: cleaning outliers"
    script:
        "../scripts/clean.py"


rule allan:
    input:
        "<results>/recordings/{recording}/clean.parquet",
    output:
        "<results>/recordings/{recording}/allan.parquet",
    log:
        "<logs>/allan/{recording}.log",
    benchmark:
        "<benchmarks>/allan/{recording}.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("allan.py", "noise", "pipeline"),
        allan=config["allan"],
    message:
        "{wildcards.recording}: Allan deviations"
    script:
        "../scripts/allan.py"


rule psd:
    input:
        "<results>/recordings/{recording}/clean.parquet",
    output:
        "<results>/recordings/{recording}/psd.parquet",
    log:
        "<logs>/psd/{recording}.log",
    benchmark:
        "<benchmarks>/psd/{recording}.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("psd.py", "noise", "pipeline"),
        psd=config["psd"],
    message:
        "{wildcards.recording}: power spectral density"
    script:
        "../scripts/psd.py"


rule gaussian:
    input:
        "<results>/recordings/{recording}/clean.parquet",
    output:
        gaussian="<results>/recordings/{recording}/gaussian.csv",
        covariance="<results>/recordings/{recording}/covariance.csv",
    log:
        "<logs>/gaussian/{recording}.log",
    benchmark:
        "<benchmarks>/gaussian/{recording}.tsv"
    resources:
        mem_mb=memory(2000),
        runtime=minutes(10),
    params:
        code=source("gaussian.py", "noise", "pipeline"),
        gaussian=config["gaussian"],
    message:
        "{wildcards.recording}: Gaussian model"
    script:
        "../scripts/gaussian.py"


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
        mem_mb=memory(2000),
        runtime=minutes(120),
    params:
        code=source("noise.py", "noise", "pipeline"),
        subset=of_row(selection.subset_of_paper),
        settings=NOISE_SETTINGS,
    message:
        "{wildcards.recording}: noise coefficients"
    script:
        "../scripts/noise.py"


# Twins of the paper: result of S's estimator for the published noise without sampling errors.
rule expected_noise:
    input:
        "<results>/recordings/{recording}/allan.parquet",
    output:
        "<results>/recordings/{recording}/expected.csv",
    log:
        "<logs>/expected_noise/{recording}.log",
    benchmark:
        "<benchmarks>/expected_noise/{recording}.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("expected_noise.py", "noise"),
        subset=cell("camera_type", "n_cameras"),
        twin=twin_of(TWINS),
        form=of_row(partial(selection.form, twins=TWINS)),
        settings=NOISE_SETTINGS,
    message:
        "{wildcards.recording}: expected noise coefficients"
    script:
        "../scripts/expected_noise.py"


# All in one job, because importing matplotlib takes most of the time.
rule recording_figures:
    input:
        raw="<results>/recordings/{recording}/trajectories.parquet",
        clean="<results>/recordings/{recording}/clean.parquet",
        allan="<results>/recordings/{recording}/allan_masked.parquet",
        psd="<results>/recordings/{recording}/psd.parquet",
        noise="<results>/recordings/{recording}/noise.csv",
        periodogram="<results>/recordings/{recording}/periodogram.parquet",
        verdict="<results>/recordings/{recording}/verdict.json",
    output:
        report(
            "<results>/recordings/{recording}/verdict.svg",
            caption="../report/caption.rst",
            category="5 Recordings",
            subcategory="{recording}",
            labels={"result": "verdict: uncertainties, limits, causes"},
        ),
        # On the page of the recording only: in the report they would be three quarters of it
        multiext("<results>/recordings/{recording}/", "adev.svg", "psd.svg", "trajectory.svg"),
        multiext(
            "<results>/recordings/{recording}/",
            "verdict.png",
            "adev.png",
            "psd.png",
            "trajectory.png",
        ),
        fits=directory("<results>/recordings/{recording}/fit"),
    log:
        "<logs>/recording_figures/{recording}.log",
    benchmark:
        "<benchmarks>/recording_figures/{recording}.tsv"
    resources:
        mem_mb=memory(2000),
        runtime=minutes(30),
    params:
        code=source("recording_figures.py", "noise", "pipeline", "present"),
        caption=captions.VERDICT,
    message:
        "{wildcards.recording}: figures"
    script:
        "../scripts/recording_figures.py"


rule motion_capture_results:
    input:
        recordings=collect(
            "<results>/recordings/{row.recording}/{file}",
            row=EVERY_RECORDING,
            file=["allan.parquet", "psd.parquet", "gaussian.csv", "covariance.csv", "noise.csv"],
        ),
        figures=collect_outputs(
            rules.recording_figures.output,
            recording=accepted(selection.names, EVERY),
        ),
