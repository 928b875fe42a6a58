# Does the noise fall with each camera, and which one raises it? From the subsets of a take.


rule cameras:
    input:
        raw=of_subsets("trajectories.parquet"),
        covariance=of_subsets("covariance.csv"),
        noise=of_subsets("noise.csv"),
    output:
        csv=report(
            "<results>/tables/{group}_cameras.csv",
            caption="../report/cameras.rst",
            category="Groups",
            subcategory="{group}",
            labels={"item": "cameras (table)", "shows": "noise with each camera added"},
        ),
        md="<results>/tables/{group}_cameras.md",
        law=report(
            "<results>/tables/{group}_camera_law.csv",
            caption="../report/cameras.rst",
            category="Groups",
            subcategory="{group}",
            labels={"item": "number of cameras (table)", "shows": "exponent of S Eq. 3"},
        ),
        law_md="<results>/tables/{group}_camera_law.md",
        json="<results>/tables/{group}_cameras.json",
        svg=report(
            "<results>/figures/{group}_cameras.svg",
            caption="../report/cameras.rst",
            category="Groups",
            subcategory="{group}",
            labels={"item": "cameras", "shows": "noise with each camera added"},
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
        code=digest("cameras.py"),
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
