# What calibrations ask of other rows. Functions only: rules are in other files.

OF_SETUP = f"{OF_GROUP} and setup == '{{setup}}'"


def stations_to_track_with(wildcards):
    """pose.json of the calibration that the row's board is tracked with, unless it is refused."""
    other = CALIBRATIONS.rows[wildcards.calibration].tracked_with_row
    if other is None or not is_accepted(CALIBRATIONS.rows[other]):
        return {}
    return {"tracked_with": f"{config['results']}/calibrations/{other}/pose.json"}


def at_rest(rows):
    """Calibrations whose board may be at rest; of twins it is known."""
    still = {name for name, twin in CALIBRATION_TWINS.items() if twin.motion.pattern == "still"}
    return [row for row in rows if row.twin is None or row.twin in still]


def noise_of_angles(wildcards):
    """allan.parquet of the row, if its board may be at rest."""
    folder = f"{config['results']}/calibrations/{wildcards.calibration}"
    found = at_rest([CALIBRATIONS.rows[wildcards.calibration]])
    return {"allan": f"{folder}/allan.parquet"} if found else {}


def setups(query=OF_GROUP):
    """Function of the wildcards: group, setup and source of the setups whose recordings are joined."""
    every = accepted_calibrations(selection.setups, query)
    return every if config["lighthouse"]["joint"] == "setup" else lambda wildcards: []


def poses_of_setups(query=OF_GROUP):
    """Function of the wildcards: their pose.json."""
    every = setups(query)
    return lambda wildcards: [
        f"{config['results']}/setups/{group}/{setup}/pose.json"
        for group, setup, _ in every(wildcards)
    ]
