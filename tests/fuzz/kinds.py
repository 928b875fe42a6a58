"""Every kind of input: sound files, how the package reads them, how the strict readers do."""

import json
import sys
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests"
sys.path[:0] = [str(p) for p in (TESTS, TESTS / "io/c3d", TESTS / "io/text", ROOT / "workflow")]
sys.path.append(str(TESTS / "lighthouse/decode"))

import make_c3d  # noqa: E402
import synthetic  # noqa: E402
import text_files  # noqa: E402
import yaml  # noqa: E402
from mocap_workflow import recording_twins, rows, startup  # noqa: E402
from mocap_workflow.recordings import RecordingRow  # noqa: E402
from sample_files import samples_folder  # noqa: E402

from mocap_metrology import settings  # noqa: E402
from mocap_metrology.common.entries import load_twins  # noqa: E402
from mocap_metrology.common.errors import Refusal  # noqa: E402
from mocap_metrology.common.faults import Faults  # noqa: E402
from mocap_metrology.common.files import read_table, write_table  # noqa: E402
from mocap_metrology.io.read import FORMATS, labels_of, orientation_of, read_recording  # noqa: E402
from mocap_metrology.lighthouse.board import read_board  # noqa: E402
from mocap_metrology.lighthouse.decode.angles_csv import read_angles  # noqa: E402
from mocap_metrology.lighthouse.decode.chain import decode  # noqa: E402
from mocap_metrology.lighthouse.decode.dump import read_dump  # noqa: E402
from mocap_metrology.lighthouse.decode.libsurvive import read_libsurvive  # noqa: E402

from . import kinds_beside, mutate, strict_c3d, strict_tables, strict_text  # noqa: E402
from .kind import Kind  # noqa: E402
from .strict_c3d import Values  # noqa: E402

LABELS = ("A", "B")
CHAINED = 8  # of so many mutants of a Lighthouse recording one goes through all of decoding


def mutant(kind: Kind, seed: int, index: int) -> tuple[bytes, str]:
    """The bytes of one mutant, and how it was made."""
    rng = np.random.default_rng([seed, zlib.crc32(kind.name.encode()), index])
    return kind.damage(kind.base, rng)


def positions(paths: list[Path], labels: tuple[str, ...] = LABELS) -> Values:
    found = read_recording(paths, labels, second_opinion=False)
    return {
        "position_mm": found.position_mm,
        "rate": found.frame_rate_hz,
        "unit_assumed": "assumed" in found.unit_source,
    }


def of_c3d(folder: Path) -> Iterator[Kind]:
    """C3D files of every encoding, small; one longer than 16 bits count; two segments."""
    points = make_c3d.still(60)
    points[7, 0, 3], points[9, 1, :3] = -1, np.nan
    steps = np.round(np.nan_to_num(points) * 10).astype(int)
    analog = np.random.default_rng(2).normal(0, 1, (60, 6)).astype("f4")
    floats = {"scale": -0.1}
    made = {
        "float": (points, floats),
        "metres": (points * np.float32([1e-3, 1e-3, 1e-3, 1]), {"units": "m"}),
        "int16": (steps, {"scale": 0.1}),
        "dec-float": (np.nan_to_num(points), floats | {"processor": "DEC"}),
        "dec-int16": (steps, {"scale": 0.1, "processor": "DEC"}),
        "mips-float": (points, floats | {"processor": "MIPS"}),
        "mips-int16": (steps, {"scale": 0.1, "processor": "MIPS"}),
        "trial": (points, {"trial": (1, 60), "long_frames": 60}),
        "unpadded": (points, {"pad": False}),
        "analog": (points, {"analog": analog}),
        "long": (make_c3d.still(66_000), {"trial": (1, 66_000), "frames": 65535}),
    }
    for name, (values, how) in made.items():
        path = make_c3d.build(folder / "a.c3d", values, labels=LABELS, **how)
        yield _c3d(f"c3d {name}", path.read_bytes(), LABELS)
    parts = [
        make_c3d.build(folder / f"{k}.c3d", points[:30], labels=LABELS, trial=ends, header=ends)
        for k, ends in enumerate(((1, 30), (36, 65)))
    ]
    first, last = (path.read_bytes() for path in parts)

    def both(path: Path) -> Values:
        (path.parent / "first.c3d").write_bytes(first)
        return positions([path.parent / "first.c3d", path])

    yield Kind("c3d segments", "a.c3d", last, both,
               lambda raw: strict_c3d.join([first, raw], LABELS) | {"first": 1},
               partial(mutate.binary, front=1024))  # fmt: skip


def _c3d(name: str, base: bytes, labels: tuple[str, ...]) -> Kind:
    front = (int.from_bytes(base[16:18], "big" if base[515:516] == b"V" else "little") - 1) * 512
    return Kind(
        name,
        "a.c3d",
        base,
        lambda path: positions([path], labels),
        lambda raw: strict_c3d.read(raw, labels),
        lambda raw, rng: mutate.c3d(raw, rng, front),
    )


def of_text() -> Iterator[Kind]:
    """Exports of every program, with a gap."""
    take = text_files.still()
    take[5, 1] = np.nan
    made = {
        "trc": ("a.trc", text_files.trc(LABELS, 100, take), strict_text.trc),
        "motive": ("a.csv", text_files.motive(LABELS, 100, take), strict_text.motive),
        "nexus": ("a.csv", text_files.nexus(LABELS, 100, take), strict_text.nexus),
        "qualisys": ("a.tsv", text_files.qualisys(LABELS, 100, take), strict_text.qualisys),
        "table": ("a.csv", text_files.table(LABELS, 100, take), strict_tables.table),
        "first principles": (
            "a.tsv",
            text_files.first_principles(LABELS, 50, take),
            strict_tables.first_principles,
        ),
    }
    for name, (file, text, strict) in made.items():
        yield Kind(f"text {name}", file, text.encode(), lambda path: positions([path]),
                   partial(strict, labels=LABELS), mutate.text)  # fmt: skip
    stored, names = np.nan_to_num(take, nan=-3.697314e28), ("Marker_1", "Marker_2")
    yield Kind("text n3d", "a.n3d", text_files.n3d(stored, 100),
               lambda path: positions([path], names), partial(strict_tables.n3d, labels=names),
               partial(mutate.binary, front=256))  # fmt: skip
    rng = np.random.default_rng(3)
    places = rng.normal([0.3, 0.4, 1.5], 1e-4, (40, 3))
    lines = [f"1 0 0 {x:.6f} 0 1 0 {y:.6f} 0 0 1 {z:.6f}" for x, y, z in places]
    text = "\n".join(["# Freq: 250", *lines, ""])
    yield Kind("text poses", "a.txt", text.encode(), _poses,
               partial(strict_text.poses, labels=("tracker",)), mutate.text)  # fmt: skip


def _poses(path: Path) -> Values:
    found = positions([path], ("tracker",))
    with suppress(Refusal):  # of the orientation alone
        orientation_of([path], "tracker")
    return found


def _pulses(found: Any, per_s: float) -> np.ndarray:
    start, length = (np.round(getattr(found, f"{w}_s") * per_s) for w in ("start", "length"))
    table = np.stack([start, length, found.diode.astype(float)], axis=1)
    return table[np.lexsort((table[:, 2], table[:, 0]))]


def of_lighthouse() -> Iterator[Kind]:
    """A dump, a recording of libsurvive, angles, a board."""
    scene = synthetic.Scene(seconds=0.6).build()
    made = "\n".join(f"{x:.4f},{y:.4f},{z:.4f}" for x, y, z in synthetic.BOARD)
    board = f"x_m,y_m,z_m\n{made}\n".encode()

    def chained(path: Path, kind: str, places: str = "") -> None:
        if zlib.crc32(path.read_bytes()[-4096:]) % CHAINED == 0:
            (path.parent / "board.csv").write_bytes(board)
            with suppress(Refusal):  # of what the reader alone takes
                decode(path, kind, places or path.parent / "board.csv")

    def of_dump(path: Path) -> Values:
        chained(path, "gpio-dump")
        return {"pulses": _pulses(read_dump(path), 2e6), "words": path.stat().st_size // 4}

    words = scene.words().astype("<u4").tobytes()
    yield Kind("lighthouse dump", "a.bin", words, of_dump, strict_text.dump,
               lambda raw, rng: mutate.binary(raw, rng, len(raw)))  # fmt: skip

    first, end, diode = scene.samples()
    order = np.lexsort((diode, first))
    config = {"modelPoints": synthetic.BOARD.tolist(), "channelMap": list(range(32))[::-1]}
    lines = [f"0.1 HMD CONFIG {json.dumps({'lighthouse_config': config})}", "0.1 INFO LOG begin"]
    lines += [
        f"{f / 2e6:.6f} HMD C {31 - d} {24 * f % 2**32} {24 * (e - f)}"
        for f, e, d in zip(first[order], end[order], diode[order], strict=True)
    ]

    def of_rec(path: Path) -> Values:
        chained(path, "libsurvive-rec", "HMD")
        pulses, places = read_libsurvive(path, "HMD")
        return {"pulses": _pulses(pulses, 48e6), "board": places}

    def strict_rec(raw: bytes) -> Values:
        found = strict_text.rec(raw, "HMD")
        table = found["pulses"]
        return found | {"pulses": table[np.lexsort((table[:, 2], table[:, 0]))]}

    text = "\n".join([*lines[:900], ""]).encode()
    yield Kind("lighthouse rec", "a.rec", text, of_rec, strict_rec, mutate.text)

    rows = [f"{'master' if s == 0 else 'slave'},{a},{c},{d},{t:.7f},{angle:.8f}"
            for s, a, c, d, t, angle in scene.hits if c < 20]  # fmt: skip
    head = "station,axis,cycle,diode,time_s,angle_rad"

    def of_angles(path: Path) -> Values:
        chained(path, "angles-csv")
        hits, _ = read_angles(path)
        names = ("station", "axis", "cycle", "diode", "time_s", "angle_rad")
        return {"hits": np.stack([getattr(hits, name).astype(float) for name in names], axis=1)}

    yield Kind("lighthouse angles", "a.csv", "\n".join([head, *rows, ""]).encode(), of_angles,
               strict_text.angles, mutate.text)  # fmt: skip
    yield Kind("lighthouse board", "a.csv", board, lambda path: {"board": read_board(path)},
               strict_text.board, mutate.text)  # fmt: skip


def of_workflow(folder: Path) -> Iterator[Kind]:
    """A sheet, the configuration, the file of twins, an intermediate file."""
    columns = ("recording", "path", "group", "unit", "comment", "camera_type")
    head = ("recording", "path", "markers", "group", "n_cameras", "camera_ids", "frame_rate_hz",
            "unit", "date", "camera_type", "comment")  # fmt: skip
    cells = (
        ("one", "a.c3d", "A;B", "hall", "3", "1;2;3", "119.88", "mm", "2026-11-20", "T40", "x"),
        ("two", "b.c3d;a.c3d", "A;B;C", "hall", "", "4;5", "", "m", "", "", "words, more words"),
        ("three", "simulate:T", "", "office", "", "", "", "", "", "T160", ""),
    )
    sheet = "\n".join("\t".join(line) for line in (head, *cells)) + "\n"

    def of_sheet(path: Path) -> Values:
        for name in ("a.c3d", "b.c3d"):
            (path.parent / name).touch()
        found = rows.load(RecordingRow, str(path), ["T"])
        table = []
        for row in found.values():
            files = ";".join(Path(one).name for one in row.paths) if not row.twin else None
            own = {"path": files or f"simulate:{row.twin}"}
            table.append([own.get(c, getattr(row, c, "")) or "" for c in columns])
        return {"rows": sorted(table)}

    yield Kind("workflow sheet", "sheet.tsv", sheet.encode(), of_sheet, strict_text.sheet,
               mutate.text)  # fmt: skip

    def loaded(path: Path) -> dict[str, object]:
        startup.check_files([path])
        found = yaml.safe_load(path.read_text(encoding="utf-8"))  # as Snakemake does
        if not isinstance(found, dict):
            raise Faults(["no mapping"])
        return found

    def of_config(path: Path) -> Values:
        settings.checked(loaded(path))
        made = settings.checked(loaded(path)).model_dump(mode="json")
        return strict_text.configuration(yaml.safe_dump(made).encode())

    text = (ROOT / "config/config.yaml").read_bytes()
    yield Kind("workflow config", "config.yaml", text, of_config, strict_text.configuration,
               mutate.text)  # fmt: skip

    def of_twins(path: Path) -> Values:
        found = load_twins(str(path))
        common = {"duration_s": 60.0, "form": "sampled"}
        for name, twin in found["twins"].items():
            recording_twins.recording_twin(twin, name, common)
        kept = {key: value for key, value in found.items() if value}
        return strict_text.configuration(yaml.safe_dump(kept).encode())

    twins = yaml.safe_load((ROOT / "config/twins.yaml").read_text(encoding="utf-8"))
    some = {name: twin for name, twin in twins["twins"].items() if "published" in twin}
    text = yaml.safe_dump({"twins": dict(list(some.items())[:6])}).encode()
    yield Kind("workflow twins", "twins.yaml", text, of_twins, strict_text.configuration,
               mutate.text)  # fmt: skip

    rng = np.random.default_rng(4)
    table = {"frame": np.arange(3000, dtype=np.int32), "x1_mm": rng.normal(300, 1, 3000)}
    write_table(folder / "a.parquet", table, {"unit": "mm", "frame_rate_hz": 120.0})
    base = (folder / "a.parquet").read_bytes()

    def of_parquet(path: Path) -> Values:
        columns, origin = read_table(path)
        return {**columns, "origin": json.dumps(origin, sort_keys=True)}

    def as_written(raw: bytes) -> Values:
        strict_c3d.need(raw == base)
        return of_parquet(folder / "a.parquet")

    yield Kind("workflow parquet", "b.parquet", base, of_parquet, as_written,
               lambda raw, rng: mutate.binary(raw, rng, len(raw)))  # fmt: skip


UNREAD = ("1123x01EMG.c3d", "badParameterOffset.c3d", "phasespace_sample.c3d", "Optotrak.c3d",
          "MyCube.c3d", "analogs.csv", "markers_without_header.csv", "imu_test.trc",
          "20200918_Exp1_laserData.csv", "20201001_Exp1_laserData.csv")  # fmt: skip


def real_files() -> list[Path]:
    """Recordings by other people that are readable: two frames or more, whole, with points."""
    folder = samples_folder()
    suffixes = {".c3d", *FORMATS} - {".txt"}
    files = sorted(folder.rglob("*")) if folder else []
    files = [p for p in files if p.suffix.lower() in suffixes and p.name not in UNREAD]
    files = [p for p in files if {"allan", "lighthouse"}.isdisjoint(p.parts)]
    return files + (sorted(folder.glob("static_vive_pose/*.txt")) if folder else [])


def of_real() -> Iterator[Kind]:
    """Small C3D files of other people that the strict reader takes, too."""
    for path in real_files():
        if path.suffix.lower() == ".c3d" and path.stat().st_size < 300_000:
            raw, labels = path.read_bytes(), labels_of(path)
            seen = [label for label in labels if labels.count(label) == 1 and ";" not in label]
            for label in seen[:6]:
                try:
                    strict_c3d.read(raw, (label,))
                    positions([path], (label,))
                except (strict_c3d.Unreadable, ValueError):
                    continue
                yield _c3d(f"c3d real {path.stem}", raw, (label,))
                break


def every() -> dict[str, Kind]:
    """All kinds by name."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    kinds = [*of_c3d(folder), *of_real(), *of_text(), *of_lighthouse(), *of_workflow(folder)]
    kinds += kinds_beside.every(folder)
    return {kind.name: kind for kind in kinds}
