"""The contents of pose.json out of a calibration: what to use, how far, and against what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Row
from mocap_metrology.lighthouse.assess import fit_checks, pose_file
from mocap_metrology.lighthouse.assess.comparison import Comparison, compare_with_earlier
from mocap_metrology.lighthouse.assess.network_reference import NetworkReference
from mocap_metrology.lighthouse.assess.reference import Reference, check_ids, errors
from mocap_metrology.lighthouse.assess.validation import Verdict, verdict, worst_of
from mocap_metrology.lighthouse.calibrate.jansen import Calibration, chosen
from mocap_metrology.lighthouse.records import MASTER, ROLES, SLAVE, Path, Station

NO_POSE: Row = {"moved": None, "valid": None}  # nothing to compare
APART_P = 0.01  # by chance, of all comparisons of an object together


@dataclass(frozen=True)
class Summary:
    """document: contents of pose.json but for its sentences, which are of verdict and comparison
    with an earlier pose, where one is given."""

    document: pose_file.PoseFile
    verdict: Verdict
    comparison: Comparison | None = None


def board_rms_urad(paths: Sequence[Path]) -> float:
    """Root mean square of angles about single board poses, of the worse station: the median of
    sqrt(K_1 / (angles - 6)) in urad."""
    rms = [np.median(np.sqrt(p.epsilon / np.maximum(p.n_angles - 6, 1))) for p in paths]
    return 1e6 * float(max(rms))


def summary(
    calibration: Calibration,
    stations: Sequence[Station],
    *,
    duration_s: float | None = None,
    resolution_s: float | None = None,
    notes: Sequence[str] = (),
    reference: Reference | NetworkReference | None = None,
    truths: Mapping[str, Reference] | None = None,
    earlier: str | None = None,
) -> Summary:
    """pose.json of a calibration; stations: master first. Of any number of stations each is whole
    as a slave of the reference.

    resolution_s: step of the recording's clock; reference: what a lab measured; truths: of a twin,
    by frame, optical or housing, which no lab has: each pose then has `truth_errors_mm` and
    `truth_errors_deg`; earlier: a pose.json to compare with. Raises `Refusal` where the reference
    or the earlier pose is of other stations.
    """
    network, note = calibration.network, ""
    pairs, true = {ROLES[SLAVE]: stations}, dict[str, Reference]()
    if network is not None:
        first, *others = network.connected
        by_name = {station.role: station for station in stations}
        pairs = {name: (by_name[first], by_name[name]) for name in others}
        if isinstance(reference, NetworkReference):
            true, note = reference.seen_from(first, stations)
    elif isinstance(reference, Reference):
        true, note = {ROLES[SLAVE]: reference}, check_ids(reference, stations)
    taken, verdicts = dict[str, int](), dict[str, Verdict]()
    span, board_rms, places = None, None, 0.0
    for name, pair in pairs.items():
        rows = [k for k, pose in enumerate(calibration.estimates) if pose.station == name]
        poses = [calibration.estimates[k] for k in rows]
        index, best, off = chosen(poses), None, None
        if index is not None:
            taken[name], best = rows[index], poses[index]
            if (paths := calibration.paths_of(best)) is not None:
                # The diagonal of the box of the inner 98 %.
                ends = np.percentile(paths[MASTER].t_m, [1, 99], axis=0)
                span, board_rms = float(np.linalg.norm(ends[1] - ends[0])), board_rms_urad(paths)
                if (known := calibration.joints.get(best.optics)) is not None:
                    # What errors of the board, as stated, make of it at the nearer station.
                    nearest = min(np.median(np.linalg.norm(path.t_m, axis=1)) for path in paths)
                    sd, n = known[0].priors.board_position_mm, len(known[0].board)
                    places = fit_checks.places_urad(1e-3 * sd, float(nearest), n)
            if name in true:
                off = errors(best.R, best.t_m, true[name])
        verdicts[name] = verdict(
            best,
            poses,
            pair,
            n_common=(calibration.n_common or None) if network is None else network.common[name],
            span_m=span,
            duration_s=duration_s,
            expected_urad=fit_checks.expected_noise_urad(resolution_s if network is None else None),
            board_rms_urad=board_rms,
            places_urad=places,
            errors=off,
            variants=calibration.variants,
            exchanged=calibration.exchanged,
            why_none="; ".join(calibration.why),
        )
    of_path: Row = {"span_m": span, "duration_s": duration_s, "board_rms_urad": board_rms}
    if network is not None:
        of_path = {"common": dict(network.common), "duration_s": duration_s}
    diagnostics = {
        "still": calibration.still,
        "n_common": calibration.n_common,
        **of_path,
        "left_out": list(calibration.why),
        "notes": [one for one in (*notes, note) if one],
    }
    if network is None:
        (whole,) = verdicts.values()
    else:
        whole = worst_of(verdicts, list(network.apart.values()))
    of_all = taken, whole, diagnostics, true, network
    result = pose_file.pose_json(calibration.estimates, stations, *of_all)
    for entry, pose in zip(result["poses"], calibration.estimates if truths else (), strict=False):
        mm, deg = errors(pose.R, pose.t_m, (truths or {})[pose.frame])
        entry |= {"truth_errors_mm": mm.tolist(), "truth_errors_deg": deg.tolist()}
    return _compared(calibration, result, whole, earlier)


def _compared(
    calibration: Calibration, result: pose_file.PoseFile, whole: Verdict, earlier: str | None
) -> Summary:
    """The summary with the variants and the comparison with the earlier pose; of several stations
    the worst one."""
    result["variants"] = [way.as_dict() for way in calibration.variants]
    if earlier is None:
        return Summary(result, whole)
    with_pose = {
        name: one for name, one in pose_file.pairs(result).items() if one["chosen"] is not None
    }
    old = pose_file.pairs(pose_file.read_pose_json(earlier)) if with_pose else {}
    both = [(one, old[name]) for name, one in with_pose.items() if name in old]
    if calibration.network is not None:
        both = [pair for pair in both if pair[1]["chosen"] is not None]
    comparisons = [compare_with_earlier(*pair) for pair in both]
    worst = max(comparisons, key=lambda one: (one.moved, not one.valid, *one.shift), default=None)
    result["check_against"] = NO_POSE if worst is None else worst.as_dict()
    return Summary(result, whole, worst)


def refused(stations: Sequence[Station], why: str) -> Summary:
    """pose.json of a calibration that cannot be: no pose, and the reason."""
    return summary(Calibration(why=[why]), stations)


def with_objects(first: Summary, others: Mapping[str, pose_file.PoseFile]) -> Summary:
    """The summary with a check against the poses from other objects of the same recording, by name.

    Of m comparisons the least probability by chance p counts as min(1, m p). Below `APART_P` one
    pose at least is farther off than stated, and it is unknown which: the word is one worse, but
    `failed` only where it was so before. Others that are `failed` state nothing. Without a
    comparison the summary is unchanged.
    """
    compared: list[tuple[Comparison, str]] = []
    for name, other in others.items():
        with suppress(Refusal):  # without a pose, or of other stations
            one = compare_with_earlier(first.document, other, one_board=False)
            if other["verdict"]["word"] != "failed" and np.isfinite(one.p_value):
                compared.append((one, name))
    if not compared:
        return first
    worst, name = min(compared, key=lambda pair: pair[0].p_value)
    p, word = min(1.0, len(compared) * worst.p_value), first.verdict.word
    level = "good" if p >= APART_P else fit_checks.WORDS[min(fit_checks.WORDS.index(word) + 1, 2)]
    cases, (mm, deg) = (fit_checks.Case.OBJECTS, fit_checks.Case.OBJECTS_APART), worst.shift
    check = fit_checks.judged("objects agree", cases, p, "", (level, APART_P), mm=mm, deg=deg)
    check = replace(check, names=(name,))
    word = max(word, level, key=fit_checks.WORDS.index)
    whole = replace(first.verdict, word=word, checks=(*first.verdict.checks, check))
    document: pose_file.PoseFile = {
        **first.document,
        "verdict": first.document["verdict"] | {"word": word},
        "checks": [*first.document["checks"], pose_file.check_row(check)],
    }
    return replace(first, document=document, verdict=whole)
