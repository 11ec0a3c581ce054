# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of every layout, against what `hapt export` wrote of them."""

import csv
import re
import unittest
import warnings
from pathlib import Path

import hapticd
import numpy as np

GOLDEN = Path(__file__).resolve().parents[2] / "proto/log/golden"
MEMBERS = {"position": "p", "orientation": "q", "linear": "v", "angular": "w", "force": "f", "torque": "t"}
UNIT = re.compile(r"_(m|N|Nm|s|m_per_s|rad_per_s|per_m|N_per_m|Nm_per_rad|N_s|kg|kgm²|Ns|Nms)$")


def columns(path):
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    return {name: np.array([row[i] for row in rows[1:]]) for i, name in enumerate(rows[0])}


def field_of(array, column):
    """The numbers of a column of fixed fields; none: it is of a list, or not ours."""
    words = UNIT.sub("", column).split(".")
    for word in words:
        name = MEMBERS.get(word, word)
        if array.dtype.names and name in array.dtype.names:
            array = array[name]
        elif word in ("x", "y", "z", "w") and array.dtype.names is None and array.ndim == 2:
            array = array[:, "xyzw".index(word)]
        else:
            return None
    return array if array.ndim == 1 and array.dtype.names is None else None


class Logs(unittest.TestCase):
    def test_fixed_fields_of_every_layout_are_as_exported(self):
        for path in sorted(GOLDEN.glob("layout_*.mcap")):
            log = hapticd.open_log(path)
            for topic, file in (("/servo0/frame", "servo0_frame"), ("/sim/frame", "sim_frame"),
                                ("/contact0/set", "contact0_set"), ("/control/frame", "control_frame")):
                with warnings.catch_warnings(record=True) as caught:
                    warnings.simplefilter("always")
                    records = log[topic]
                if path.stem != f"layout_{hapticd.abi}":
                    self.assertIn("recorded with layout", str(caught[0].message))
                compared = 0
                for column, texts in columns(path.with_suffix(f".{file}.csv")).items():
                    ours = field_of(records.array, column)
                    if ours is None:
                        continue
                    theirs = texts.astype(float) if ours.dtype == float else texts.astype(ours.dtype)
                    np.testing.assert_array_equal(ours, theirs, f"{path.name}: {column}")
                    compared += 1
                self.assertGreater(compared, 3, f"{path.name}: {topic}")

    def test_lists_are_as_exported(self):
        log = hapticd.open_log(GOLDEN / "layout_12.mcap")
        sets, table = log["/contact0/set"], columns(GOLDEN / "layout_12.contact0_set.csv")
        most = 0
        for i in range(len(sets)):
            contacts = sets.contacts(i)
            self.assertEqual(len(contacts), int(table["n_contacts"][i]))
            most = max(most, len(contacts))
            for k, contact in enumerate(contacts):
                self.assertEqual(contact["normal_O"][2], float(table[f"contacts[{k}].normal_O.z"][i]))
            pose = sets.objects(i)["X_WO"][0]
            self.assertEqual(pose["q"][3], float(table["objects[0].X_WO.orientation.w"][i]))
        self.assertGreater(most, 0)
        with self.assertRaises(IndexError):
            sets.contacts(len(sets))

    def test_what_is_said_of_a_recording(self):
        log = hapticd.open_log(GOLDEN / "layout_12.mcap")
        self.assertEqual(log.topics["/servo0/frame"], "ServoFrame")
        self.assertEqual((log.session, log.session_file), ("peg-in-hole", ""))
        self.assertTrue(log.is_finished)
        self.assertEqual(len(log.events), len(columns(GOLDEN / "layout_12.events.csv")["code"]))
        self.assertEqual(log.events["code"][0], hapticd.EventCode.STARTED)

    def test_a_part_of_the_time(self):
        log = hapticd.open_log(GOLDEN / "layout_12.mcap")
        every = log["/servo0/frame"]
        some = log.records("/servo0/frame", int(every.t_ns[2]), int(every.t_ns[5]))
        np.testing.assert_array_equal(some["tick"], every["tick"][2:6])
        self.assertEqual(len(log.records("/servo0/frame", int(every.t_ns[-1]) + 1)), 0)

    def test_what_cannot_be_read_is_one_line(self):
        for path, words in ((GOLDEN / "layout_12.events.csv", "MCAP"), ("/nowhere.mcap", "nowhere")):
            with self.assertRaisesRegex(hapticd.Error, words):
                hapticd.open_log(path)
        with self.assertRaisesRegex(hapticd.Error, "no topic '/servo'; there are /servo0/frame"):
            hapticd.open_log(GOLDEN / "layout_12.mcap").records("/servo")


if __name__ == "__main__":
    unittest.main()
