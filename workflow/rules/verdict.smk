# Diagnosis and verdict of each recording, in words and figures; a table for each group.


# In one job: starting Python with matplotlib takes as long as either.
rule verdict:
    input:
        raw="<results>/recordings/{recording}/trajectories.parquet",
        clean="<results>/recordings/{recording}/clean.parquet",
        outliers="<results>/recordings/{recording}/outliers.csv",
        allan="<results>/recordings/{recording}/allan_masked.parquet",
        psd="<results>/recordings/{recording}/psd.parquet",
        noise="<results>/recordings/{recording}/noise.csv",
        periodogram="<results>/recordings/{recording}/periodogram.parquet",
        check=CHECK,
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
        multiext(
            "<results>/recordings/{recording}/",
            "diagnosis.json",
            "events.csv",
            "periodic.csv",
            "filters.csv",
            "diagnosis.svg",
            "diagnosis.png",
        ),
        json="<results>/recordings/{recording}/verdict.json",
        fits=directory("<results>/recordings/{recording}/fit"),
    log:
        "<logs>/verdict/{recording}.log",
    benchmark:
        "<benchmarks>/verdict/{recording}.tsv"
    resources:
        mem_mb=memory(1000, arrays=9),
        runtime=minutes(30, seconds=3.5),
    params:
        code=source("verdict.py", "noise", "pipeline", "present"),
        captions=[captions.VERDICT, captions.DIAGNOSIS],
        row=columns("recording", "group", "twin", "camera_type", "n_cameras"),
        diagnosis=config["diagnosis"],
        still=config["still"],
        verdict=config["verdict"],
        confidence=config["allan"]["confidence"],
        fits=config["fit_figures"],
    message:
        "{wildcards.recording}: diagnosis, verdict and figures"
    script:
        "../scripts/verdict.py"


rule summary:
    input:
        checks=checks(RECORDINGS, OF_GROUP),
        verdicts=collect("<results>/recordings/{row.recording}/verdict.json", row=accepted()),
    output:
        csv="<results>/tables/{group}_summary.csv",
        md="<results>/tables/{group}_summary.md",
    log:
        "<logs>/summary/{group}.log",
    benchmark:
        "<benchmarks>/summary/{group}.tsv"
    localrule: True
    resources:
        mem_mb=memory(500),
        runtime=minutes(10),
    params:
        code=source("summary.py", "noise", "present"),
    message:
        "{wildcards.group}: verdicts"
    script:
        "../scripts/summary.py"


rule verdict_results:
    input:
        recordings=collect(
            "<results>/recordings/{row.recording}/{file}",
            row=EVERY_RECORDING,
            file=["verdict.json", "diagnosis.json", "events.csv", "periodic.csv", "filters.csv"],
        ),
        figures=collect_outputs(
            rules.verdict.output,
            recording=accepted(selection.names, EVERY),
        ),
        tables=collect_outputs(rules.summary.output, group=groups()),
