"""Labels of points: completion, choice, and form in messages."""

from __future__ import annotations

import re
from collections.abc import Sequence

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.faults import nearest, shortened


def complete_labels(labels: Sequence[str], n_points: int) -> tuple[str, ...]:
    """One label a point; a point without one is called `point_12`, counted from 1."""
    stated = [*labels[:n_points], *[""] * (n_points - len(labels))]
    return tuple(label or f"point_{i}" for i, label in enumerate(stated, start=1))


def in_words(labels: Sequence[str], most: int = 20) -> str:
    """Labels for a message, a long list cut short."""
    text = ", ".join(shortened(label, 60) for label in labels[:most])
    return text if len(labels) <= most else f"{text}, … and {len(labels) - most} more"


COMPUTED = re.compile(
    r"(angles?|forces?|moments?|powers?)v?$|cent(re|er)ofmass|virtual", re.IGNORECASE
)
AUTO = "auto"  # in the place of the two ends of a bar
SEGMENT = ("O", "A", "L", "P")  # ends of the labels of Vicon's axes of a segment: LFOO, LFOA, ...


def numbered(labels: Sequence[str]) -> list[str]:
    """Labels as markers are chosen by, in order: one that occurs twice is `A#1` and `A#2`."""
    stripped = [label.strip() for label in labels]
    counts: dict[str, int] = {}
    unique = []
    for label in stripped:
        counts[label] = counts.get(label, 0) + 1
        unique.append(f"{label}#{counts[label]}" if stripped.count(label) > 1 else label)
    return unique


def is_unlabelled(label: str) -> bool:
    """Whether a label is one that software gives to a trajectory without a name."""
    return label.startswith(("*", "Unlabeled", "Unlabelled", "Unidentified"))


def computed_labels(labels: Sequence[str]) -> frozenset[int]:
    """Places (from 0) of labels of computed quantities and points, and of axes of segments."""
    known = set(labels)
    segments = {label[:-1] for label in known if all(label[:-1] + end in known for end in SEGMENT)}
    return frozenset(
        place
        for place, label in enumerate(labels)
        if COMPUTED.search(label) or label[:-1] in segments
    )


def find_points(labels: Sequence[str], markers: Sequence[str], file: str) -> list[int]:
    """Places (from 0) of the chosen `markers` among `labels`.

    A marker is a label, or its part after the subject's prefix (`C7` for `Matt:C7`) where that is
    one point only, or `LABEL#2` for the second point of that label.
    """
    if not markers:
        raise Refusal(f"{file}: no marker is chosen; the file has: {in_words(labels)}")
    places = [_find(labels, marker.strip(), file) for marker in markers]
    for i, place in enumerate(places):
        if place in places[:i]:
            raise Refusal(f"{file}: marker {markers[i].strip()!r} is chosen twice")
    return places


def _find(labels: Sequence[str], marker: str, file: str) -> int:
    same = [i for i, label in enumerate(labels) if label == marker]
    if len(same) == 1:
        return same[0]
    if same:
        raise Refusal(
            f"{file}: {len(same)} points are labelled {marker!r}: choose one of them as"
            f" {', '.join(f'{marker}#{k}' for k in range(1, len(same) + 1))}"
        )
    if numbered := re.fullmatch(r"(.+)#([0-9]+)", marker):
        same = [i for i, label in enumerate(labels) if label == numbered[1]]
        if same and 1 <= int(numbered[2]) <= len(same):
            return same[int(numbered[2]) - 1]
        if same:
            raise Refusal(f"{file}: no {marker!r}: points labelled {numbered[1]!r}: {len(same)}")
    suffix = [i for i, label in enumerate(labels) if ":" in label and _bare_label(label) == marker]
    if len(suffix) == 1:
        return suffix[0]
    if suffix:
        several = in_words([labels[i] for i in suffix])
        raise Refusal(f"{file}: marker {marker!r} occurs several times: choose from {several}")
    meant = suggestion(marker, labels)
    raise Refusal(
        f"{file}: no marker {shortened(marker, 60)!r}; {meant or f'there are: {in_words(labels)}'}"
    )


def suggestion(wrong: str, labels: Sequence[str]) -> str:
    """What a marker that is not there was probably meant to be, in words; empty without a guess.

    `wrong` may be several labels with another separator than `;`, a label in other letter case, or
    one misspelt; the subject's prefix (`Matt:`) may be missing.
    """
    known = {label: label for label in labels} | {
        _bare_label(label): label for label in labels[::-1]
    }
    between = r"\s*[,;|]\s*" if re.search("[,;|]", wrong) else r"\s+"
    parts = [part for part in re.split(between, wrong) if part]
    if len(parts) > 1 and all(part in known for part in parts):
        return f'separate the labels with ";": "{";".join(parts)}"'
    folded = {name.casefold(): label for name, label in known.items()}
    same = folded.get(wrong.casefold())
    if same is not None:
        return f"the letter case differs: did you mean {same}?"
    if len(parts) > 1 and any(part in known for part in parts):
        return 'separate labels with ";"'
    near = list(dict.fromkeys(folded[name] for name in nearest(wrong.casefold(), folded)))
    return f"did you mean {' or '.join(near)}?" if near else ""


def _bare_label(label: str) -> str:
    return re.sub("^[^:]*:", "", label).strip()


def pair_of(
    text: str,
    labels: Sequence[str],
    where: str,
    expected: str = f"{AUTO}, or two markers of the file",
    name: str = "bar",
) -> tuple[str, str]:
    """`A-B` as two labels of a file; a label may itself hold a `-`. where, name: where it stands
    and what it is called, for a refusal."""
    cuts = [k for k, letter in enumerate(text) if letter == "-"]
    pairs = [(text[:k].strip(), text[k + 1 :].strip()) for k in cuts]
    pairs = [(a, b) for a, b in pairs if a != b and {a, b} <= set(labels)]
    if len(pairs) != 1:
        what = f'{name} is "{text}"; expected {expected} joined by "-"'
        raise Refusal(f"{where}: {what}: {in_words(labels, 60)}")
    return pairs[0]
