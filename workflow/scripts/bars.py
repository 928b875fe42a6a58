"""Takes of the bars of a group -> <group>_bar: all passes together, as tables and a figure."""

from step import step

with step(snakemake) as log:
    import json
    from pathlib import Path

    from mocap_metrology.recording.bar import write_group
    from mocap_metrology.settings import Settings

    given, output = snakemake.input, snakemake.output
    still = [json.loads(Path(path).read_text(encoding="utf-8")) for path in given.verdicts]
    settings, group = Settings(**snakemake.params.settings), snakemake.wildcards.group
    write_group(group, given.takes, still, settings, Path(output.json), Path(output.svg))
    log.info("%d takes", len(given.takes))
