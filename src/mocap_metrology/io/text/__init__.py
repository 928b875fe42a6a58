"""Recordings of any format that is read, by the suffix of the path, with the same checks.

Text: TRC (`.trc`), Motive and Vicon Nexus (`.csv`, told apart by content), Qualisys (`.tsv`),
poses of a tracker (`.txt`). Everything else is taken for C3D. Nothing else in this project knows
of these formats.
"""

from mocap_metrology.io.text.pose_txt import Poses, read_pose_txt
from mocap_metrology.io.text.read import bodies_of, labels_of, orientation_of, read_any

__all__ = ["Poses", "bodies_of", "labels_of", "orientation_of", "read_any", "read_pose_txt"]
