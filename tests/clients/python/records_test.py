# SPDX-License-Identifier: GPL-3.0-or-later
"""The data types lie in memory as the C++ structs do."""

import json
import os
import re
import subprocess
import unittest
from pathlib import Path

import hapticd
from hapticd import _records

ROOT = Path(__file__).resolve().parents[3]
HAPT = Path(os.environ["HAPTICD_BIN"]).with_name("hapt")
WIRE = json.loads(subprocess.run([HAPT, "wire", "--json"], capture_output=True, check=True).stdout)


class Records(unittest.TestCase):
    def test_every_field_lies_where_the_struct_has_it(self):
        self.assertEqual(hapticd.abi, WIRE["abi"])
        looked_at = 0
        for name, record in WIRE["records"].items():
            kind = hapticd.dtype(name)
            fixed = [field for field in record["fields"] if not field.get("is_part")]
            parts = [field for field in record["fields"] if field.get("is_part")]
            self.assertEqual(list(kind.names), [field["name"] for field in fixed], name)
            for field in fixed:
                made, offset = kind.fields[field["name"]][:2]
                self.assertEqual((offset, made.itemsize), (field["offset"], field["size"]), field)
                looked_at += 1
            self.assertEqual(kind.itemsize, parts[0]["offset"] if parts else record["size"], name)
            for field in parts:
                value = _records.lists_of(name)[field["name"]][1]
                self.assertEqual(value.itemsize * field["count"] + 8, field["size"], field)
        self.assertGreater(looked_at, 100)

    def test_members_of_compounds_have_their_order(self):
        pose = hapticd.dtype("ServoFrame")["X_WT"]
        self.assertEqual([pose.fields[key][1] for key in "pq"], [0, 24])
        self.assertEqual(hapticd.dtype("ServoFrame")["F_device_B"]["t"].shape, (3,))
        self.assertEqual(hapticd.dtype("GivenMotion")["mobility"].shape, (36,))

    def test_each_list_has_an_accessor(self):
        for record, kind in (
            ("ServoFrame", _records.ServoLists),
            ("ContactSet", _records.ContactLists),
            ("SceneFrame", _records.SceneLists),
            ("GivenFrame", _records.GivenLists),
        ):
            for name in _records.lists_of(record):
                self.assertTrue(callable(getattr(kind, name)), name)

    def test_an_unknown_record_is_named(self):
        with self.assertRaisesRegex(ValueError, "no record 'Servo'; there are .*ServoFrame"):
            hapticd.dtype("Servo")

    def test_flags_are_those_of_the_header(self):
        text = (ROOT / "proto/wire/wire.h").read_text()
        looked_at = 0
        for name, body in re.findall(r"enum (?:class )?(\w+)[^{;]*\{(.*?)\n\};", text, re.S):
            kind = getattr(hapticd, name, None)
            if kind is None:
                continue
            values = re.findall(r"k\w+ =\s+(\d+)(?:u << (\d+))?", body)
            ours = [int(one) << int(shift or 0) for one, shift in values]
            self.assertEqual([int(one) for one in kind.__members__.values()], ours, name)
            looked_at += 1
        self.assertEqual(looked_at, 8)


if __name__ == "__main__":
    unittest.main()
