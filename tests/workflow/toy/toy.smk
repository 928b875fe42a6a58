# The shape of the real rules, with files of text.
forks.LEAST_JOBS = 99  # which need nothing loaded


checkpoint clean:
    input:
        files=files(selection.paths),
    output:
        check="<results>/recordings/{recording}/check.json",
        trajectories="<results>/recordings/{recording}/trajectories.parquet",
    log:
        "<logs>/clean/{recording}.log",
    benchmark:
        "<benchmarks>/clean/{recording}.tsv"
    wildcard_constraints:
        recording=RECORDINGS.pattern(source="measured"),
    priority: 10
    params:
        code=source("toy.py"),
    script:
        "../scripts/toy.py"


rule clean_twin:
    output:
        trajectories="<results>/recordings/{recording}/trajectories.parquet",
    log:
        "<logs>/clean/{recording}.log",
    benchmark:
        "<benchmarks>/clean/{recording}.tsv"
    wildcard_constraints:
        recording=RECORDINGS.pattern(source="twin"),
    params:
        code=source("toy.py"),
        twin=cell("twin"),
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


promise(
    recordings=collect("<results>/recordings/{row.recording}/noise.csv", row=EVERY_RECORDING),
    tables=collect("<results>/tables/{group}_noise.csv", group=groups()),
)
