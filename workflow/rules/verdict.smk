# Verdict of each recording, with its reason; a table for each group.


rule verdict:
    input:
        clean="<results>/recordings/{recording}/clean.parquet",
        outliers="<results>/recordings/{recording}/outliers.csv",
        allan="<results>/recordings/{recording}/allan_masked.parquet",
        noise="<results>/recordings/{recording}/noise.csv",
        check=CHECK,
        diagnosis="<results>/recordings/{recording}/diagnosis.json",
    output:
        "<results>/recordings/{recording}/verdict.json",
    log:
        "<logs>/verdict/{recording}.log",
    benchmark:
        "<benchmarks>/verdict/{recording}.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(30),
    params:
        code=source("verdict.py", "noise", "pipeline", "present"),
        row=columns("recording", "group", "twin", "camera_type", "n_cameras"),
        verdict=config["verdict"],
        confidence=config["allan"]["confidence"],
    message:
        "{wildcards.recording}: verdict"
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
        recordings=collect("<results>/recordings/{row.recording}/verdict.json", row=EVERY_RECORDING),
        tables=collect_outputs(rules.summary.output, group=groups()),
