# Disturbances of a recording: events, lines, resolution, filters, in words and in a figure.


rule diagnosis:
    input:
        raw="<results>/recordings/{recording}/trajectories.parquet",
        psd="<results>/recordings/{recording}/psd.parquet",
        noise="<results>/recordings/{recording}/noise.csv",
    output:
        json="<results>/recordings/{recording}/diagnosis.json",
        events="<results>/recordings/{recording}/events.csv",
        periodic="<results>/recordings/{recording}/periodic.csv",
        filters="<results>/recordings/{recording}/filters.csv",
        svg="<results>/recordings/{recording}/diagnosis.svg",
        png="<results>/recordings/{recording}/diagnosis.png",
    log:
        "<logs>/diagnosis/{recording}.log",
    benchmark:
        "<benchmarks>/diagnosis/{recording}.tsv"
    resources:
        mem_mb=memory(1000, arrays=16),
        runtime=minutes(30),
    params:
        code=source("diagnosis.py", "noise", "pipeline", "present"),
        caption=captions.DIAGNOSIS,
        diagnosis=config["diagnosis"],
        still=config["still"],
        horizon_s=config["verdict"]["horizon_s"],
    message:
        "{wildcards.recording}: diagnosis"
    script:
        "../scripts/diagnosis.py"


rule diagnosis_results:
    input:
        recordings=collect(
            "<results>/recordings/{row.recording}/{file}",
            row=EVERY_RECORDING,
            file=["diagnosis.json", "events.csv", "periodic.csv", "filters.csv"],
        ),
        figures=collect(
            "<results>/recordings/{row.recording}/diagnosis.{kind}",
            row=EVERY_RECORDING,
            kind=FIGURE,
        ),
