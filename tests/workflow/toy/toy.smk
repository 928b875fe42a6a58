# The shape of the real rules, with files of text.
rule simulate_recording:
    output:
        temp("<results>/recordings/{recording}/twin.c3d"),
    log:
        "<logs>/simulate_recording/{recording}.log",
    benchmark:
        "<benchmarks>/simulate_recording/{recording}.tsv"
    params:
        code=source("toy.py"),
        twin=cell("twin"),
    script:
        "../scripts/toy.py"


checkpoint check_recording:
    input:
        files=FILES,
    output:
        "<results>/recordings/{recording}/check.json",
    log:
        "<logs>/check_recording/{recording}.log",
    benchmark:
        "<benchmarks>/check_recording/{recording}.tsv"
    params:
        code=source("toy.py"),
    script:
        "../scripts/toy.py"


rule trajectories:
    input:
        files=FILES,
        check=CHECK,
    output:
        "<results>/recordings/{recording}/trajectories.parquet",
    log:
        "<logs>/trajectories/{recording}.log",
    benchmark:
        "<benchmarks>/trajectories/{recording}.tsv"
    priority: 10
    params:
        code=source("toy.py"),
    script:
        "../scripts/toy.py"


rule noise:
    input:
        files="<results>/recordings/{recording}/trajectories.parquet",
    output:
        "<results>/recordings/{recording}/noise.csv",
    log:
        "<logs>/noise/{recording}.log",
    benchmark:
        "<benchmarks>/noise/{recording}.tsv"
    params:
        code=source("toy.py"),
        hampel=config["hampel"],
    script:
        "../scripts/toy.py"


rule group_table:
    input:
        files=collect("<results>/recordings/{row.recording}/noise.csv", row=accepted()),
    output:
        "<results>/tables/{group}_noise.csv",
    log:
        "<logs>/group_table/{group}.log",
    benchmark:
        "<benchmarks>/group_table/{group}.tsv"
    params:
        code=source("toy.py"),
    script:
        "../scripts/toy.py"


rule toy_results:
    input:
        recordings=collect("<results>/recordings/{row.recording}/noise.csv", row=EVERY_RECORDING),
        tables=collect("<results>/tables/{group}_noise.csv", group=groups()),
