# What is wrong with a recording: events, lines, resolution, filters, in words and in a figure.


rule diagnosis:
    input:
        raw="<results>/recordings/{recording}/trajectories.parquet",
        psd="<results>/recordings/{recording}/psd.parquet",
        noise="<results>/recordings/{recording}/noise.csv",
    output:
        json="<results>/recordings/{recording}/diagnosis.json",
        events=report(
            "<results>/recordings/{recording}/events.csv",
            caption="../report/diagnosis_events.rst",
            category="Recordings",
            subcategory="{recording}",
            labels={"item": "diagnosis", "shows": "events"},
        ),
        periodic=report(
            "<results>/recordings/{recording}/periodic.csv",
            caption="../report/diagnosis_periodic.rst",
            category="Recordings",
            subcategory="{recording}",
            labels={"item": "diagnosis", "shows": "periodic disturbances"},
        ),
        filters=report(
            "<results>/recordings/{recording}/filters.csv",
            caption="../report/diagnosis_filters.rst",
            category="Recordings",
            subcategory="{recording}",
            labels={"item": "diagnosis", "shows": "what filters leave"},
        ),
        svg=report(
            "<results>/recordings/{recording}/diagnosis.svg",
            caption="../report/diagnosis.rst",
            category="Recordings",
            subcategory="{recording}",
            labels={"item": "diagnosis", "shows": "figure"},
        ),
        png="<results>/recordings/{recording}/diagnosis.png",
    log:
        "<logs>/diagnosis/{recording}.log",
    benchmark:
        "<benchmarks>/diagnosis/{recording}.tsv"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        code=digest("diagnosis.py"),
        diagnosis=config["diagnosis"],
        still=config["still"],
        horizon_s=config["verdict"]["horizon_s"],
    message:
        "{wildcards.recording}: diagnosis"
    script:
        "../scripts/diagnosis.py"
