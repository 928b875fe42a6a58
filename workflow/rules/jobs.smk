# The rules noted by `job`, each with a script, a log and a benchmark of its name.
for NAME, OF in JOBS.items():

    rule:
        name:
            NAME
        input:
            *map(unpack, OF["unpacked"]),
            **OF["input"],
        output:
            **OF["output"],
        log:
            f"<logs>/{OF['place']}.log",
        benchmark:
            f"<benchmarks>/{OF['place']}.tsv"
        wildcard_constraints:
            **OF["only"],
        priority: OF["priority"]
        localrule: OF["local"]
        resources:
            mem_mb=OF["mem_mb"],
            runtime=OF["runtime"],
        params:
            **OF["params"],
            code=source(f"{OF['script']}.py"),
            script=OF["script"],
        message:
            OF["message"]
        script:
            "../scripts/{params.script}.py"  # by name: OF is the last one when a job runs
