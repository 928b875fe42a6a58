# Future work of S: noise of an orientation, of a moving pair, and by place.

WITH_PLACE = accepted(selection.with_place)


rule orientation:
    input:
        trajectories="<results>/recordings/{recording}/trajectories.parquet",
        poses=branch(of_row(has_bodies), then=MEASURED_FILES),
    output:
        series="<results>/recordings/{recording}/orientation.parquet",
        allan="<results>/recordings/{recording}/allan_orientation.parquet",
        csv="<results>/recordings/{recording}/orientation.csv",
        svg=report(
            "<results>/recordings/{recording}/orientation.svg",
            caption="../report/caption.rst",
            category="5 Recordings",
            subcategory="{recording}",
            labels={"result": "orientation: Allan deviation of a rotation vector"},
        ),
        png="<results>/recordings/{recording}/orientation.png",
    log:
        "<logs>/orientation/{recording}.log",
    benchmark:
        "<benchmarks>/orientation/{recording}.tsv"
    resources:
        mem_mb=memory(1000, arrays=9),
        runtime=minutes(30, seconds=3.0),
    params:
        code=source("orientation.py", "io", "noise", "present"),
        caption=captions.ORIENTATION,
        contents=contents(selection.paths),
        cluster=cell("cluster"),
        accept_truncated=cell("accept_truncated"),
        names=cell("column_names"),
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
            caption="../report/caption.rst",
            category="5 Recordings",
            subcategory="{recording}",
            labels={"result": "by place: length of a moving pair over the volume"},
        ),
        png="<results>/recordings/{recording}/place.png",
    log:
        "<logs>/place/{recording}.log",
    benchmark:
        "<benchmarks>/place/{recording}.tsv"
    resources:
        mem_mb=memory(1000, arrays=12),
        runtime=minutes(30, seconds=0.9),
    params:
        code=source("place.py", "coordinates.py", "noise", "present"),
        caption=captions.PLACE,
        place=config["place"],
    message:
        "{wildcards.recording}: noise by place"
    script:
        "../scripts/place.py"


rule places:
    input:
        allan=collect("<results>/recordings/{row.recording}/allan_masked.parquet", row=WITH_PLACE),
        clean=collect("<results>/recordings/{row.recording}/clean.parquet", row=WITH_PLACE),
    output:
        csv="<results>/tables/{group}_places.csv",
        md="<results>/tables/{group}_places.md",
    log:
        "<logs>/places/{group}.log",
    benchmark:
        "<benchmarks>/places/{group}.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("places.py", "noise", "present"),
        rows=columns("recording", "place", "markers", of=WITH_PLACE),
        sources=column("source", of=WITH_PLACE),
    message:
        "{wildcards.group}: noise by place"
    script:
        "../scripts/places.py"


rule motion_results:
    input:
        tables=collect_outputs(rules.places.output, group=groups(selection.with_place)),
        figures=together(
            collect_outputs(rules.orientation.output, recording=accepted(turned, EVERY)),
            collect_outputs(rules.place.output, recording=accepted(moved, EVERY)),
        ),
