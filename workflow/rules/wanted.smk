# What each target asks for, as lists of paths. Functions only: rules are in other files.


def wanted(target):
    """Results of a target: the entries of WANTED, filled in, or what they return when called."""
    kinds = list(WANTED) if target == "all" else [target]
    paths = []
    for entry in (entry for kind in kinds for entry in WANTED[kind]):
        if callable(entry):
            paths += entry()
        elif "{recording}" in entry:
            paths += [entry.replace("{recording}", name) for name in accepted()]
        elif "{calibration}" in entry:
            paths += [entry.replace("{calibration}", name) for name in accepted_calibrations()]
        else:
            paths += [entry.replace("{group}", group) for group in accepted_groups()]
    return paths


def paper_tables():
    """Tables of the papers: only their own groups feed them."""
    found = "skurowski2019" in accepted_groups()
    numbers = (1, 2, 3, 4, "A1") if found else ()  # the rule of A1 makes A2 and A3 too
    tables = [f"<results>/tables/skurowski_table{number}.csv" for number in numbers]
    if accepted_calibrations("jansen2019"):
        tables.append("<results>/tables/jansen_table1.csv")  # its rule makes all three
    return tables + (["<results>/tables/left_out.csv"] if tables else [])


def calibration_tables():
    """Tables of every group with an accepted calibration."""
    return [
        f"<results>/tables/{group}_calibrations.csv"
        for group in calibration_groups()
        if accepted_calibrations(group)
    ]


def calibration_figures():
    """A figure of every accepted calibration; of twins only the first of each setup, unless asked
    for by name: they are many, and look alike."""
    names = accepted_calibrations()
    first = {calibration_row(name)["setup"]: name for name in reversed(names)}
    return [
        f"<results>/calibrations/{name}/calibration.png"
        for name in names
        if not calibration_row(name)["twin"] or first[calibration_row(name)["setup"]] == name
    ]


def of_figure(number):
    """SVG of a figure of the paper, for the report."""
    caption, shows = SKUROWSKI_FIGURES[number]
    return report(
        f"<results>/figures/skurowski_fig{number:02d}.svg",
        caption=f"../report/{caption}.rst",
        category="2 Skurowski & Pawlyta 2019",
        labels={"result": f"Figure {number:2d}: {shows}"},
    )


def paper_figures():
    """Figures of the papers."""
    found = "skurowski2019" in accepted_groups()
    numbers = (1, 6, 9) if found else ()  # each rule makes several
    figures = [f"<results>/figures/skurowski_fig{number:02d}.svg" for number in numbers]
    if accepted_calibrations("jansen2019"):
        figures.append("<results>/figures/jansen_fig03.svg")
    return figures


def scaling_figures():
    """How the spread falls with the number of cameras, of groups that have several of one type;
    the paper's own is among its figures."""
    found = []
    for group in accepted_groups():
        counts = {(row(name)["camera_type"], row(name)["n_cameras"]) for name in accepted(group)}
        types = [kind for kind, count in counts if count]
        if len(types) > len(set(types)) and group != "skurowski2019":
            found.append(f"<results>/figures/{group}_scaling.svg")
    return found


def checks_of_target(target):
    """What has to be checked for a target; recordings and calibrations ask nothing of each other."""
    of_recordings = [] if target == "calibrations" else checks()
    return of_recordings + ([] if target == "recordings" else calibration_checks())


def gate_of(target):
    """What a target asks for: its gate, or nothing at all when the sheets are empty."""
    return [f"<results>/gate/{target}.json"] if RECORDINGS or CALIBRATIONS else []


# Changes between recordings.


def allan_of(recording):
    return f"<results>/recordings/{recording}/allan_masked.parquet"


def cleaned_allan_of(recording):
    """As S has it, for figures of the paper."""
    return f"<results>/recordings/{recording}/allan.parquet"


def sources_of(recordings):
    """`twin` or `measured` by name."""
    return {name: row(name)["source"] for name in recordings}


def comparisons(group):
    """Pairs of recording and reference, see mocap_workflow/comparisons.py."""
    return compared.pairs([row(name) for name in accepted(group)], accepted())


def dated_series(group):
    """Recordings of the same cameras on three days or more."""
    return compared.series_over_dates([row(name) for name in accepted(group)])


def with_covariate(group):
    """Recordings with something recorded beside them."""
    return [name for name in accepted(group) if row(name)["covariate"]]


def with_place(group):
    """Recordings whose place in the volume has a name; none if it is the same for all."""
    names = [name for name in accepted(group) if row(name)["place"]]
    return names if len({row(name)["place"] for name in names}) > 1 else []


def has_poses(recording):
    """Whether a label that was chosen is a body, with an orientation beside its position."""
    return not is_twin(recording) and bool(verdict(recording).get("bodies"))


def motion_results():
    """Orientation of clusters and of poses, and length by place of pairs that move."""
    turned = [name for name in accepted() if row(name)["cluster"] or has_poses(name)]
    moved = [name for name in accepted() if not is_twin(name) and verdict(name).get("moving")]
    results = [f"<results>/recordings/{name}/orientation.svg" for name in turned]
    pairs = [name for name in moved if len(row(name)["markers"]) > 1]
    return results + [f"<results>/recordings/{name}/place.svg" for name in pairs]


def change_tables():
    """What has changed in each group, as far as its sheet allows to tell."""
    kinds = {"compare": comparisons, "trend": dated_series, "coherence": with_covariate}
    kinds |= {"places": with_place}
    return [
        f"<results>/tables/{group}_{kind}.csv"
        for group in accepted_groups()
        for kind, found in kinds.items()
        if found(group)
    ]


# Subsets of cameras.


def camera_takes(group):
    """Recordings of subsets of the same cameras, take by take, see mocap_workflow/cameras.py."""
    return cameras.takes([row(name) for name in accepted(group)])


def subsets_of(group):
    """All of them in one list."""
    return sum(camera_takes(group), [])


def of_subsets(file):
    """Input function: a file of each of them."""
    return lambda wildcards: [
        f"<results>/recordings/{name}/{file}" for name in subsets_of(wildcards.group)
    ]


def camera_tables():
    """What the cameras add, in each group with a subset and a larger one."""
    return [
        f"<results>/tables/{group}_cameras.csv" for group in accepted_groups() if subsets_of(group)
    ]


# Pages of the report.


def results_without_report():
    """Everything `all` asks for but the pages of the report."""
    return [path for target in WANTED if target != "report" for path in wanted(target)]


def tables_as_text():
    """The Markdown of every wanted table, and of those that the same rules make."""
    found = []
    for path in wanted("tables"):
        own = path.replace("<results>", config["results"])
        made_by = next(r for r in workflow.rules if any(out.match(own) for out in r.output))
        match = next(out.match(own) for out in made_by.output if out.match(own))
        made = [str(out.apply_wildcards(match.groupdict())) for out in made_by.output]
        found += [out for out in made if out.endswith(".md")]
    return list(dict.fromkeys(found))


def entry_of(wildcards):
    """Where the report shows the page of a table."""
    return reporting.entry(f"{config['results']}/tables/{wildcards.table}.md")


def verdict_files():
    """Verdict of every accepted recording."""
    return [f"<results>/recordings/{name}/verdict.json" for name in accepted()]


def groups_with_cameras():
    """Groups in which something is said about single cameras."""
    return [group for group in accepted_groups() if subsets_of(group)]


def links_of_report():
    """Where names on the front page lead: `recording T40-10` -> an address within the report."""
    links = {
        f"recording {name}": reporting.link("5 Recordings", name, f"{name}/verdict.svg")
        for name in accepted()
    }
    for path in calibration_figures():
        name = Path(path).parent.name
        link = reporting.link("6 Calibrations", "Other", f"{name}/calibration.svg")
        links[f"calibration {name}"] = link
    return links


def origins():
    """Results that know the checksums of the inputs, in the order of `inputs_of_report`."""
    kinds = {"recordings/{}/trajectories.parquet": accepted()}
    kinds |= {"calibrations/{}/pose.json": accepted_calibrations()}
    return [f"<results>/{file.format(name)}" for file, names in kinds.items() for name in names]


def inputs_of_report():
    """Name, kind, source and seed of every accepted recording and calibration."""
    kinds = {"recording": (accepted(), row, TWINS)}
    kinds["calibration"] = (accepted_calibrations(), calibration_row, CALIBRATION_TWINS)
    return [
        {
            "name": name,
            "kind": kind,
            "source": row_of(name)["source"],
            "seed": twins[row_of(name)["twin"]]["seed"] if row_of(name)["twin"] else None,
        }
        for kind, (names, row_of, twins) in kinds.items()
        for name in names
    ]


def configuration_of_report():
    """The configuration without folders of this machine: sheets by name."""
    sheets = ("recordings", "calibrations", "twins")
    plain = {key: Path(config[key]).name if config[key] else None for key in sheets}
    return {key: value for key, value in (config | plain).items() if key != "results"}


# Recordings side by side.


def families():
    """Figures of each group of two recordings or more. One recording has them in its own folder;
    those of the paper are its own figures."""
    return [
        f"<results>/figures/{group}_adev.svg"  # its rule makes the others
        for group in accepted_groups()
        if group != "skurowski2019" and len(accepted(group)) > 1
    ]


def shocked():
    """The recording with a shock that Figure 7 of the first paper shows, if there is one."""
    return accepted("skurowski2019-crump")[:1]


def of_shock(file):
    """Input function: a file of it."""
    return lambda wildcards: [f"<results>/recordings/{name}/{file}" for name in shocked()][0]


def references_of(names):
    """The accepted recordings that these are compared with."""
    found = dict.fromkeys(row(name)["compare_with"] for name in names)
    return [name for name in found if name in accepted()]


def unshocked():
    return references_of(shocked())


def repaired():
    """Recordings of Figure A1 of the first paper."""
    return accepted("skurowski2019-repaired")


def unrepaired():
    return references_of(repaired())


def twin_values(names, key):
    """Values of one setting of the twins among these recordings, those that have it."""
    return [twin_settings(n)[key] for n in names if is_twin(n) and key in twin_settings(n)]


def with_and_without_failing():
    """All ten Vantage cameras, of which one failed, and the others without it."""
    names = accepted("skurowski2019")
    of = [[n for n in names if camera_subset(n) == ("Vantage", count)][:1] for count in (10, 9)]
    return sum(of, []) if all(of) else []


def paper_families():
    """Figures of the first paper that compare recordings, as far as there are any to compare."""
    found = {
        "07": shocked(),
        "08": with_and_without_failing(),
        "12": accepted("skurowski2019"),  # its rule makes 13 too
        "A1": repaired(),
    }
    return [f"<results>/figures/skurowski_fig{n}.svg" for n, names in found.items() if names]


# Claims.


def of_calibration(calibration, file):
    return f"<results>/calibrations/{calibration}/{file}"


def moved_twins():
    """Twins of the second paper's group: how they were moved is known."""
    return [name for name in accepted_calibrations("jansen2019") if calibration_row(name)["twin"]]


def first_of_setups():
    """The first calibration of each of its simulated setups."""
    names = [n for n in moved_twins() if calibration_row(n)["setup"].startswith("sim-")]
    return list({calibration_row(name)["setup"]: name for name in reversed(names)}.values())[::-1]


def claim_tables():
    """Where there is a recording or a calibration of a paper's group."""
    found = accepted("skurowski2019") or accepted_calibrations("jansen2019")
    return ["<results>/tables/claims.csv"] if found else []
