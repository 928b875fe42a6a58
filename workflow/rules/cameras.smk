# Effect of each camera on the noise, from the subsets of a take.

SUBSETS = accepted(selection.subsets)


rule cameras:
    input:
        raw=collect("<results>/recordings/{row.recording}/trajectories.parquet", row=SUBSETS),
        covariance=collect("<results>/recordings/{row.recording}/covariance.csv", row=SUBSETS),
        noise=collect("<results>/recordings/{row.recording}/noise.csv", row=SUBSETS),
    output:
        csv="<results>/tables/{group}_cameras.csv",
        md="<results>/tables/{group}_cameras.md",
        law="<results>/tables/{group}_camera_law.csv",
        law_md="<results>/tables/{group}_camera_law.md",
        json="<results>/tables/{group}_cameras.json",
        svg=report(
            "<results>/figures/{group}_cameras.svg",
            caption="../report/caption.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "cameras: noise with each camera added"},
        ),
        png="<results>/figures/{group}_cameras.png",
    log:
        "<logs>/cameras/{group}.log",
    benchmark:
        "<benchmarks>/cameras/{group}.tsv"
    resources:
        mem_mb=memory(1500),
        runtime=minutes(30),
    params:
        code=source("cameras.py", "noise", "present"),
        caption=captions.CAMERAS,
        takes=accepted(selection.takes),
        rows=columns("recording", "camera_type", "camera_ids", of=SUBSETS),
        cameras=config["cameras"],
        mask_sigma=config["noise"]["mask_sigma"],
        half_window_s=config["hampel"]["half_window_s"],
    message:
        "{wildcards.group}: noise by number of cameras"
    script:
        "../scripts/cameras.py"


rule cameras_results:
    input:
        tables=collect_outputs(rules.cameras.output, group=groups(selection.subsets)),
