# Is it good enough? A word, its reason and a picture of each recording; a table of each group.


rule verdict:
    input:
        clean="<results>/recordings/{recording}/clean.parquet",
        outliers="<results>/recordings/{recording}/outliers.csv",
        allan="<results>/recordings/{recording}/allan_masked.parquet",
        noise="<results>/recordings/{recording}/noise.csv",
        check=check_of,
        diagnosis="<results>/recordings/{recording}/diagnosis.json",
    output:
        json="<results>/recordings/{recording}/verdict.json",
        svg=report(
            "<results>/recordings/{recording}/verdict.svg",
            caption="../report/verdict.rst",
            category="5 Recordings",
            subcategory="{recording}",
            labels={"result": "verdict: uncertainties, limits, causes"},
        ),
        png="<results>/recordings/{recording}/verdict.png",
    log:
        "<logs>/verdict/{recording}.log",
    benchmark:
        "<benchmarks>/verdict/{recording}.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=source("verdict.py", "noise", "present"),
        row=columns("recording", "group", "twin", "camera_type", "n_cameras"),
        verdict=config["verdict"],
        confidence=config["allan"]["confidence"],
    message:
        "{wildcards.recording}: verdict"
    script:
        "../scripts/verdict.py"


rule summary:
    input:
        checks=lambda wildcards: checks(wildcards.group),
        verdicts=of_accepted("<results>/recordings/{recording}/verdict.json"),
    output:
        csv="<results>/tables/{group}_summary.csv",
        md="<results>/tables/{group}_summary.md",
    log:
        "<logs>/summary/{group}.log",
    benchmark:
        "<benchmarks>/summary/{group}.tsv"
    threads: 1
    params:
        code=source("summary.py", "noise", "present"),
    message:
        "{wildcards.group}: verdicts"
    script:
        "../scripts/summary.py"
