"""What is wrong with a recording: diagnosis.json, its tables, and the figure that proves it."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    from coordinates import read_coordinates

    from mocap_metrology.common.files import read_table
    from mocap_metrology.noise.diagnosis.findings import findings_of
    from mocap_metrology.noise.diagnosis.recording import DiagnosisSettings, Recording, diagnose
    from mocap_metrology.present.diagnosis.diagnosis_figure import diagnosis_figure
    from mocap_metrology.present.diagnosis.tables import write_diagnosis
    from mocap_metrology.present.drawing.style import save_figure
    from mocap_metrology.present.groups.group_tables import read_noise
    from mocap_metrology.present.recording.recording_figures import source_words
    from mocap_metrology.present.text.diagnosis import sentences

    given, name = snakemake.params, snakemake.wildcards.recording
    settings = DiagnosisSettings(
        **given.diagnosis, still_range_mm=given.still["range_mm"], horizon_s=given.horizon_s
    )
    _, raw, origin = read_coordinates(snakemake.input.raw)
    recording = Recording(
        raw,
        origin["labels"],
        [tuple(pair) for pair in origin["pairs"]],
        origin["frame_rate_hz"],
        origin["resolution_mm"],
        origin["resolution_kind"],
        origin["n_filled_frames"],
    )
    noise = read_noise(snakemake.input.noise)
    psd, made = read_table(snakemake.input.psd)
    found = diagnose(recording, noise, psd, settings, made["psd"])
    findings = findings_of(recording, found, noise)
    said = sentences(recording, found, noise, settings)
    for one in said:
        log.info("%s: %s: %s", one.severity, one.kind, one.words)
    folder = Path(snakemake.output.json).parent
    write_diagnosis(folder, name, origin["source"], recording, found, findings, said)
    note = (
        f"Source: {source_words(origin)}. As recorded, isolated frames bridged. Events: at most "
        f"{100 * settings.false_alarm:g} % of sound recordings show one. Filters run both ways "
        "(fourth order, half the amplitude at the cutoff). Spectrum: medians of bins, grey up to "
        "the greatest value; behind filters by their gain."
    )
    figure = diagnosis_figure(recording, found, f"{name}: diagnosis", note)
    save_figure(figure, folder / "diagnosis")
