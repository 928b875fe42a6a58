"""Pack a finished run as a Workflow Run RO-Crate: `make crate`.

    python workflow/write_crate.py results

The archive `results/crate.zip` holds the workflow (all files of the checkout that git follows), the
configuration, tables, figures, pages and verdicts, the report if there is one, and the metadata of
the profile Workflow Run Crate 0.5. Recordings, and results in Parquet, are named by their
checksums alone.
"""

from __future__ import annotations

import argparse
import json
import mimetypes
import subprocess
import sys
import zipfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
METADATA = "ro-crate-metadata.json"
PROFILES = [
    "https://w3id.org/ro/wfrun/process/0.5",
    "https://w3id.org/ro/wfrun/workflow/0.5",
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0",
]
BIOSCHEMAS = "https://bioschemas.org/profiles/ComputationalWorkflow/1.0-RELEASE"
CONTEXT = [
    "https://w3id.org/ro/crate/1.1/context",
    "https://w3id.org/ro/terms/workflow-run/context",
]
PACKED = {".csv", ".md", ".html", ".json", ".svg", ".png", ".pdf"}
OWN = ("logs", "benchmarks", "crate.zip")
NAME = "mocap-metrology"

Entity = dict[str, Any]


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("results", type=Path, help="folder of results of a finished run")
    results = parser.parse_args(arguments).results
    if not (results / "provenance.json").is_file():
        print(f"{results}: no provenance.json; expected results of a finished run", file=sys.stderr)
        return 1
    write(results, results / "crate.zip")
    return 0


def write(results: Path, target: Path) -> None:
    """Write the archive, whole or not at all."""
    contents = {f"results/{path.relative_to(results).as_posix()}": path for path in packed(results)}
    code = {name: ROOT / name for name in followed(ROOT) if (ROOT / name).is_file()}
    part = target.with_name(f".part-{target.name}")
    with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
        document = {"@context": CONTEXT, "@graph": graph(results, contents, code)}
        archive.writestr(METADATA, json.dumps(document, indent=2, ensure_ascii=False))
        for name, path in (code | contents).items():
            archive.write(path, name)
    part.replace(target)
    print(f"{target}: {len(contents)} results, {len(code)} files of the workflow")


def packed(results: Path) -> list[Path]:
    """The results that people read."""
    return [
        path
        for path in sorted(results.rglob("*"))
        if path.suffix in PACKED and path.relative_to(results).parts[0] not in OWN
    ]


def followed(root: Path) -> list[str]:
    """Names of the files that git follows."""
    call = ["git", "-C", str(root), "ls-files", "-z"]
    listed = subprocess.run(call, capture_output=True, check=True).stdout.decode()
    return [name for name in listed.split("\0") if name]


def graph(results: Path, contents: dict[str, Path], code: dict[str, Path]) -> list[Entity]:
    """All entities: the crate, the workflow and its language, the run, its inputs and results."""
    provenance = json.loads((results / "provenance.json").read_text(encoding="utf-8"))
    inputs = [recording(k, one) for k, one in enumerate(provenance["inputs"])]
    files = [file(name, path) for name, path in contents.items()]
    others = [file(name, path) for name, path in code.items() if name != "Snakefile"]
    ended = datetime.fromtimestamp((results / "provenance.json").stat().st_mtime, UTC)
    run = {
        "@id": "#run",
        "@type": "CreateAction",
        "name": f"Run of {NAME} {provenance['code']['commit'] or provenance['code']['version']}",
        "description": "Every step from the recordings of the sheets to the pages, by Snakemake.",
        "instrument": {"@id": "Snakefile"},
        "agent": {"@id": "#agent"},
        "object": references([*inputs, *(o for o in others if o["@id"].startswith("config/"))]),
        "result": references(files),
        "startTime": began(results).isoformat(timespec="seconds"),
        "endTime": ended.isoformat(timespec="seconds"),
        "actionStatus": "http://schema.org/CompletedActionStatus",
    }
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": f"Results of {NAME}",
        "description": "How precise an optical tracking system is: a finished run of the workflow.",
        "datePublished": datetime.now(UTC).date().isoformat(),
        "author": {"@id": "#agent"},
        "license": {"@id": "LICENSE"},
        "conformsTo": [{"@id": profile} for profile in PROFILES],
        "mainEntity": {"@id": "Snakefile"},
        "mentions": {"@id": "#run"},
        "hasPart": references([{"@id": "Snakefile"}, *others, *files]),
    }
    return [descriptor(), root, *software(provenance), run, *inputs, *others, *files]


def descriptor() -> Entity:
    specifications = ("https://w3id.org/ro/crate/1.1", PROFILES[-1])
    return {
        "@id": METADATA,
        "@type": "CreativeWork",
        "about": {"@id": "./"},
        "conformsTo": [{"@id": one} for one in specifications],
    }


def software(provenance: Entity) -> list[Entity]:
    """The workflow, its language and author, and the profiles that the crate follows."""
    workflow = {
        "@id": "Snakefile",
        "@type": ["File", "SoftwareSourceCode", "ComputationalWorkflow"],
        "name": NAME,
        "version": provenance["code"]["version"],
        "license": {"@id": "LICENSE"},
        "creator": {"@id": "#agent"},
        "encodingFormat": "text/plain",
        "conformsTo": {"@id": BIOSCHEMAS},
        "programmingLanguage": {"@id": "#snakemake"},
    }
    snakemake = {
        "@id": "#snakemake",
        "@type": "ComputerLanguage",
        "name": "Snakemake",
        "version": provenance["packages"]["snakemake"],
        "identifier": {"@id": "https://snakemake.github.io"},
        "url": {"@id": "https://snakemake.github.io"},
    }
    agent = {"@id": "#agent", "@type": "Organization", "name": f"The {NAME} contributors"}
    profiles = [
        {"@id": one, "@type": "CreativeWork", "name": one, "version": one.rpartition("/")[2]}
        for one in (*PROFILES, BIOSCHEMAS)
    ]
    return [workflow, snakemake, agent, *profiles]


def recording(number: int, entry: Entity) -> Entity:
    """An input that is not in the crate: a recording, or the twin that stands for it."""
    digest = {"sha256": entry["sha256"]} if entry["sha256"] else {}
    seed = f", seed {entry['seed']}" if entry["seed"] is not None else ""
    what = f"{entry['kind']}, {entry['source']}{seed}"
    named = {"name": f"{entry['name']}: {entry['file'] or 'simulated'}", "description": what}
    return {"@id": f"#input-{number}", "@type": "CreativeWork"} | named | digest


def file(name: str, path: Path) -> Entity:
    kind = mimetypes.guess_type(path.name)[0] or "text/plain"
    size = str(path.stat().st_size)
    about = {"about": {"@id": "./"}} if name == "README.md" else {}
    entity = {"@id": name, "@type": "File", "name": name, "encodingFormat": kind}
    return entity | {"contentSize": size} | about


def references(entities: list[Entity]) -> list[Entity]:
    return [{"@id": one["@id"]} for one in entities]


def began(results: Path) -> datetime:
    """When the first job of these results began: its benchmark was written at its end."""
    starts = [(results / "provenance.json").stat().st_mtime]
    for path in (results / "benchmarks").rglob("*.tsv"):
        seconds = path.read_text(encoding="utf-8").splitlines()[-1].split("\t")[0]
        starts.append(path.stat().st_mtime - float(seconds))
    return datetime.fromtimestamp(min(starts), UTC)


if __name__ == "__main__":
    sys.exit(main())
