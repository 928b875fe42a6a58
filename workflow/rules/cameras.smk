# Does the noise fall with each camera, and which one raises it? From the subsets of a take.


rule cameras:
    input:
        raw=of_subsets("trajectories.parquet"),
        covariance=of_subsets("covariance.csv"),
        noise=of_subsets("noise.csv"),
    output:
        csv="<results>/tables/{group}_cameras.csv",
        md="<results>/tables/{group}_cameras.md",
        law="<results>/tables/{group}_camera_law.csv",
        law_md="<results>/tables/{group}_camera_law.md",
        json="<results>/tables/{group}_cameras.json",
        svg=report(
            "<results>/figures/{group}_cameras.svg",
            caption="../report/cameras.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "cameras: noise with each camera added"},
        ),
        png="<results>/figures/{group}_cameras.png",
    log:
        "<logs>/cameras/{group}.log",
    benchmark:
        "<benchmarks>/cameras/{group}.tsv"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        code=source("cameras.py", "noise", "present"),
        takes=lambda wildcards: camera_takes(wildcards.group),
        rows=lambda wildcards: columns_of(
            map(row, subsets_of(wildcards.group)), "recording", "camera_type", "camera_ids"
        ),
        sources=lambda wildcards: sources_of(subsets_of(wildcards.group)),
        cameras=config["cameras"],
        mask_sigma=config["noise"]["mask_sigma"],
        half_window_s=config["hampel"]["half_window_s"],
    message:
        "{wildcards.group}: noise with each camera added"
    script:
        "../scripts/cameras.py"
