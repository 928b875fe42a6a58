# What can be asked for. Each target ends at a gate, and what it asks for is in WANTED.


# Last of all: one line for each refused recording, and a failure if there is any.
rule gate:
    input:
        checks=lambda wildcards: checks_of_target(wildcards.target),
        results=lambda wildcards: wanted(wildcards.target),
    output:
        "<results>/gate/{target}.json",
    log:
        "<logs>/gate/{target}.log",
    benchmark:
        "<benchmarks>/gate/{target}.tsv"
    localrule: True
    threads: 1
    params:
        code=source("gate.py"),
    message:
        "Looking for refused recordings: mend what is named, or take its row out, and run again"
    script:
        "../scripts/gate.py"


rule recordings:
    input:
        gate_of("recordings"),


rule calibrations:
    input:
        gate_of("calibrations"),


rule tables:
    input:
        gate_of("tables"),


rule figures:
    input:
        gate_of("figures"),
