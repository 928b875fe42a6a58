# The shape of the real rules, with files of text.
rule simulate_recording:
    output:
        temp("<results>/recordings/{recording}/twin.c3d"),
    log:
        "<logs>/simulate_recording/{recording}.log",
    benchmark:
        "<benchmarks>/simulate_recording/{recording}.tsv"
    threads: 1
    params:
        code=source("toy.py"),
        twin=twin_of,
    script:
        "../scripts/toy.py"


checkpoint check_recording:
    input:
        files=inputs_of,
    output:
        "<results>/recordings/{recording}/check.json",
    log:
        "<logs>/check_recording/{recording}.log",
    benchmark:
        "<benchmarks>/check_recording/{recording}.tsv"
    threads: 1
    params:
        code=source("toy.py"),
    script:
        "../scripts/toy.py"


rule trajectories:
    input:
        files=inputs_of,
        check=check_of,
    output:
        "<results>/recordings/{recording}/trajectories.parquet",
    log:
        "<logs>/trajectories/{recording}.log",
    benchmark:
        "<benchmarks>/trajectories/{recording}.tsv"
    priority: 10
    threads: 1
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
    threads: 1
    params:
        code=source("toy.py"),
        hampel=config["hampel"],
    script:
        "../scripts/toy.py"


rule group_table:
    input:
        files=of_accepted("<results>/recordings/{recording}/noise.csv"),
    output:
        "<results>/tables/{group}_noise.csv",
    log:
        "<logs>/group_table/{group}.log",
    benchmark:
        "<benchmarks>/group_table/{group}.tsv"
    threads: 1
    params:
        code=source("toy.py"),
    script:
        "../scripts/toy.py"
