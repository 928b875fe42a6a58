# What S leaves to the future: noise of an orientation, of a pair that moves, and by place.


rule orientation:
    input:
        trajectories="<results>/recordings/{recording}/trajectories.parquet",
        poses=lambda wildcards: row(wildcards)["paths"] if has_poses(wildcards) else [],
    output:
        series="<results>/recordings/{recording}/orientation.parquet",
        allan="<results>/recordings/{recording}/allan_orientation.parquet",
        csv="<results>/recordings/{recording}/orientation.csv",
        svg=report(
            "<results>/recordings/{recording}/orientation.svg",
            caption="../report/orientation.rst",
            category="5 Recordings",
            subcategory="{recording}",
            labels={"result": "orientation: Allan deviation of a rotation vector"},
        ),
        png="<results>/recordings/{recording}/orientation.png",
    log:
        "<logs>/orientation/{recording}.log",
    benchmark:
        "<benchmarks>/orientation/{recording}.tsv"
    threads: 1
    resources:
        mem_mb=2500,
    params:
        code=source("orientation.py", "io", "noise", "present"),
        cluster=lambda wildcards: row(wildcards)["cluster"],
        accept_truncated=lambda wildcards: row(wildcards)["accept_truncated"],
        allan=config["allan"],
        hampel=config["hampel"],
        mask_sigma=config["noise"]["mask_sigma"],
    message:
        "{wildcards.recording}: noise of the orientation"
    script:
        "../scripts/orientation.py"


rule place:
    input:
        "<results>/recordings/{recording}/clean.parquet",
    output:
        csv="<results>/recordings/{recording}/place.csv",
        md="<results>/recordings/{recording}/place.md",
        svg=report(
            "<results>/recordings/{recording}/place.svg",
            caption="../report/place.rst",
            category="5 Recordings",
            subcategory="{recording}",
            labels={"result": "by place: length of a moving pair over the volume"},
        ),
        png="<results>/recordings/{recording}/place.png",
    log:
        "<logs>/place/{recording}.log",
    benchmark:
        "<benchmarks>/place/{recording}.tsv"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        code=source("place.py", "coordinates.py", "noise", "present"),
        place=config["place"],
    message:
        "{wildcards.recording}: noise by place"
    script:
        "../scripts/place.py"


rule places:
    input:
        allan=lambda wildcards: [allan_of(name) for name in with_place(wildcards.group)],
        clean=lambda wildcards: [
            f"<results>/recordings/{name}/clean.parquet" for name in with_place(wildcards.group)
        ],
    output:
        csv="<results>/tables/{group}_places.csv",
        md="<results>/tables/{group}_places.md",
    log:
        "<logs>/places/{group}.log",
    benchmark:
        "<benchmarks>/places/{group}.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=source("places.py", "noise", "present"),
        rows=lambda wildcards: columns_of(
            map(row, with_place(wildcards.group)), "recording", "place", "markers"
        ),
        sources=lambda wildcards: sources_of(with_place(wildcards.group)),
    message:
        "{wildcards.group}: noise by place"
    script:
        "../scripts/places.py"
