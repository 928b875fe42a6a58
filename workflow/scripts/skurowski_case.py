"""Figure 7, 8 or A1 of S: Allan deviations of recordings beside others (a shock, a failing camera,
the facility before its repair)."""

from step import step

with step(snakemake) as log:
    from mocap_metrology.common.files import read_table
    from mocap_metrology.noise.series import length_s
    from mocap_metrology.papers.shock import ShockRecording
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.skurowski import allan_figures
    from mocap_metrology.present.skurowski.results import filter_sentence
    from mocap_metrology.present.tables import sources
    from mocap_metrology.present.text import captions
    from mocap_metrology.recording.results import Table

    params, files = snakemake.params, snakemake.input
    rows = {row["recording"]: row for row in params.rows}
    others = {row["recording"]: row for row in params.others}
    every = rows | others
    allan = dict(zip(every, map(read_table, files.allan), strict=True))
    first, origin = next(iter(allan.values()))
    columns, confidence = {name: of[0] for name, of in allan.items()}, origin["allan"]["confidence"]
    lengths = {name: length_s(of) for name, (_, of) in allan.items()}

    def shocked():
        raw = Table.open(files.raw[0])
        shaken = ShockRecording(
            dict(raw.with_distances()),
            Table.open(files.clean[0]).coordinates,
            first,
            raw.origin["frame_rate_hz"],
            origin["allan"]["min_coverage"],
        )
        other = next(iter(others), None)
        quiet = (f"{other}, without a shock", columns[other]) if other else None
        chance = "is another realisation of the noise: they differ by chance. "
        source, remarks = sources(every, lengths)
        assumed = allan_figures.ASSUMED.format(**params.crumps[0]) if params.crumps else ""
        remarks = (
            f"Recording {next(iter(rows))}; the paper shows one of all its cameras. "
            f"{f'{other} {chance}' if other else ''}{assumed}{remarks}"
        )
        return allan_figures.crump_figure(shaken, quiet, source, remarks)

    def beside(figure, *shown, paper=True):
        source, remarks = sources(every, lengths, paper)
        limits = " or ".join(f"{t:g} s" for t in dict.fromkeys(params.left_out))
        guess = captions.LEFT_OUT_OF_A1.format(limits=limits) if limits else ""
        remarks = f"{filter_sentence(origin)} {remarks} {guess}".strip()
        return figure(*shown, columns, source, remarks, confidence)

    draw = {
        "07": shocked,
        "08": lambda: beside(allan_figures.failing_figure, rows),
        # S: no length after repair
        "A1": lambda: beside(allan_figures.repaired_figure, rows, others, paper=False),
    }
    save(draw[snakemake.wildcards.number](), snakemake.output[0])
