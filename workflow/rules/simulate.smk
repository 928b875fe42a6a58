# Twins: simulated stand-ins for recordings that were never published.


rule simulate_recording:
    output:
        c3d=temp("<results>/recordings/{recording}/twin.c3d"),
        truth="<results>/recordings/{recording}/truth.json",
    log:
        "<logs>/simulate_recording/{recording}.log",
    benchmark:
        "<benchmarks>/simulate_recording/{recording}.tsv"
    resources:
        mem_mb=memory(1000, arrays=9),
        runtime=minutes(30, seconds=1.2),
    params:
        code=source("simulate.py", "io", "noise"),
        name=cell("twin"),
        twin=twin_of(TWINS),
        seed=config["seed"],
    message:
        "{wildcards.recording}: simulating {params.name}"
    script:
        "../scripts/simulate.py"


rule simulate_results:
    input:
        recordings=collect(
            "<results>/recordings/{row.recording}/truth.json",
            row=accepted(query=SIMULATED),
        ),
