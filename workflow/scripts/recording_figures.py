"""Figures of one recording: Allan deviation, trajectory with replaced samples, spectrum."""

from step import step

with step(snakemake) as log:
    from pathlib import Path

    import numpy as np
    from coordinates import read_coordinates

    from mocap_metrology.common.files import read_table
    from mocap_metrology.noise.series import all_series
    from mocap_metrology.present.drawing.style import save_figure
    from mocap_metrology.present.plot.figure import save
    from mocap_metrology.present.recording.recording_figures import (
        allan_figure,
        psd_figure,
        source_words,
        step_words,
    )
    from mocap_metrology.present.recording.trajectory import trajectory_figure

    name = snakemake.wildcards.recording
    folder = Path(snakemake.output[0]).parent
    _, clean, origin = read_coordinates(snakemake.input.clean)
    _, raw, _ = read_coordinates(snakemake.input.raw)
    raw = dict(all_series(raw, [tuple(pair) for pair in origin["pairs"]]))
    changed = {k: np.isfinite(v) & (v.astype(clean[k].dtype) != clean[k]) for k, v in raw.items()}

    markers = ", ".join(f"{k} = {label}" for k, label in enumerate(origin["labels"], start=1))
    step_size = step_words(origin["resolution_mm"], origin["resolution_kind"])
    source = (
        f"Source: {source_words(origin)}. {origin['frame_rate_hz']:g} Hz, {step_size}. "
        f"Markers: {markers}."
    )
    hampel, allan = origin["hampel"], read_table(snakemake.input.allan)
    filtered = (
        f"Hampel filter, {hampel['n_sigma']:g} sigma, {origin['window_frames']} frames: "
        f"{hampel['action']}."
    )
    mask = allan[1]["noise"]["mask_sigma"]
    save(
        allan_figure(
            allan[0],
            f"{name}: Allan deviation",
            source,
            f"Masked: outliers beyond {mask:g} sigma.",
            expected=list(raw),
            confidence=allan[1]["allan"]["confidence"],
        ),
        folder / "adev",
    )
    psd, _ = read_table(snakemake.input.psd)
    title = f"{name}: power spectral density"
    save(psd_figure(psd, title, source, filtered, expected=list(raw)), folder / "psd")
    save_figure(
        trajectory_figure(
            raw,
            clean,
            changed,
            origin["frame_rate_hz"],
            f"{name}: trajectory",
            f"{source} {filtered}",
        ),
        folder / "trajectory",
    )
