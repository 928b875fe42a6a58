# An included file never sets the default target, so the entry from the top folder sets its own.
include: "workflow/Snakefile"


rule default:
    default_target: True
    input:
        rules.all.input,
