# SPDX-License-Identifier: GPL-3.0-or-later
"""Sessions on virtual time: what a hand of this test feels, and how they end."""

import json
import os
import random
import re
import signal
import struct
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
import warnings
from pathlib import Path

import hapticd
import numpy as np
from hapticd import Fault, ServoFlag

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = Path(os.environ["HAPTICD_BIN"]).parent / "haptic-lockstep"
TOP, WALL = 0.04, 800.0  # the upper face of the block [m], the coupling [N/m]
CONFIG = {
    "session": {"name": "wall"},
    "device": {"kind": "simulated-hand"},
    "coupling": {"stiffness": f"{WALL} N/m"},
    "object": [{"name": "block", "primitive": "box", "extent": ["80 mm", "80 mm", "80 mm"]}],
}
AWAY = np.array([0.0, 0.0, 0.1])  # [m], outside of the block


class PullingHand:
    """A mass on a spring and a damper to where it means to be, integrated tick by tick."""

    def __init__(self, goal, end, begin=(0, 0, TOP + 0.02), mass=0.65, stiffness=200.0, damping=20.0):
        self.goal, self.end = np.array(goal, float), end
        self.mass, self.stiffness, self.damping = mass, stiffness, damping
        self.x, self.v, self.t = np.array(begin, float), np.zeros(3), 0.0

    def __call__(self, t, wrench):
        pull = self.stiffness * (self.goal - self.x) - self.damping * self.v
        self.v = self.v + (t - self.t) / self.mass * (pull + wrench[:3])
        self.x = self.x + (t - self.t) * self.v
        self.t = t
        return self.x if t < self.end else None


def children():
    """Pids of the haptic-lockstep that this process has started."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            text = stat.read_text()
        except OSError:
            continue  # it has ended meanwhile
        if "(haptic-lockstep" in text and int(text.rsplit(")", 1)[1].split()[1]) == os.getpid():
            found.append(int(stat.parent.name))
    return found


class Lockstep(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        before, tempfile.tempdir = tempfile.tempdir, self.folder.name
        self.addCleanup(setattr, tempfile, "tempdir", before)

    def tearDown(self):
        self.assertEqual(children(), [])
        self.assertEqual([name for name in os.listdir(self.folder.name) if name.startswith("hapticd-")], [])

    def test_a_wall_pushes_as_far_as_it_is_pressed(self):
        goal = TOP - 0.02
        *_, last = hapticd.lockstep(CONFIG, PullingHand([0, 0, goal], 3.0))
        z = (200 * goal + WALL * TOP) / (200 + WALL)  # where the two springs are in balance
        self.assertAlmostEqual(last.servo["X_WT"]["p"][2], z, delta=1e-9)
        np.testing.assert_allclose(last.servo["F_device_B"]["f"], [0, 0, WALL * (TOP - z)], atol=1e-6)
        self.assertAlmostEqual(last.servo["depth"], TOP - z, delta=1e-9)
        self.assertAlmostEqual(last.t, 2.999, delta=1e-9)
        self.assertEqual(last.servo["t_ns"] - 1_000_000_000, 2_999_000_000)
        self.assertTrue(ServoFlag(int(last.servo["flags"])) & ServoFlag.CONTACT)

    def test_lists_are_those_of_the_tick(self):
        *_, last = hapticd.lockstep(CONFIG, PullingHand([0, 0, TOP - 0.02], 1.0))
        touched = last.contacts()[: int(last.contact["n_active"])]
        self.assertEqual([contact["normal_O"].tolist() for contact in touched], [[0, 0, 1]])
        self.assertAlmostEqual(touched[0]["object_point_O"][2], TOP, delta=1e-6)
        self.assertEqual(last.objects()["X_WO"]["q"].tolist(), [[0, 0, 0, 1]])
        self.assertEqual(len(last.of_contact.objects()), 1)
        for empty in (last.of_contact.guides(), last.of_contact.compliance(), last.of_servo.felt(),
                      last.of_scene.joints(), last.of_contact.givers()):
            self.assertEqual(len(empty), 0)
        self.assertEqual(last.contact["answers_tick"], last.servo["contact_tick"])
        self.assertEqual(last.scene["seq"], last.servo["scene_seq"])
        with self.assertRaises(IndexError):
            last.of_contact.contacts(1)
        with self.assertRaises(ValueError):
            last.servo["depth"] = 0.0

    def test_the_first_tick_has_no_contacts_yet(self):
        first = next(hapticd.lockstep(CONFIG, lambda t, wrench: AWAY))
        self.assertEqual((first.t, first.contact["seq"], len(first.contacts())), (0.0, 0, 0))
        self.assertTrue(ServoFlag(int(first.servo["flags"])) & ServoFlag.NO_CONTACT_SET)

    def test_what_a_body_gains_is_what_the_hand_has_pushed(self):
        body = {"name": "ball", "primitive": "sphere", "size": "40 mm", "body": {"mass": "200 g"}}
        hand = PullingHand([0, 0, 0.01], 2.0, begin=(0, 0, 0.025))
        hand.goal[2] = 0.025
        pushed = np.zeros(3)
        for step in hapticd.lockstep({**CONFIG, "object": [body]}, hand):
            pushed -= 0.001 * step.servo["F_device_B"]["f"]
            if step.t > 1.0:  # the soft start is over
                hand.goal[2] = 0.025 if step.t > 1.2 else 0.01
        gained = 0.2 * step.objects()[0]["V_WO"]["v"]
        self.assertLess(gained[2], -0.005)
        np.testing.assert_allclose(gained, pushed, atol=0.01 * np.linalg.norm(pushed))

    def test_two_runs_are_equal_to_the_last_byte(self):
        def run(goal):
            out = bytearray()
            for step in hapticd.lockstep(CONFIG, PullingHand([0.03, 0, goal], 0.7), renderer="virtual-proxy3"):
                for record in (step.servo, step.contact, step.scene, step.contacts(), step.objects()):
                    out += record.tobytes()
            return bytes(out)

        once = run(TOP - 0.02)
        self.assertEqual(once, run(TOP - 0.02))
        self.assertNotEqual(once, run(TOP - 0.020001))

    def test_a_turning_hand_has_the_velocity_of_its_places(self):
        rate, angle = 2.0, 3.0  # [rad/s], [rad] at the beginning; q changes its sign at half a turn

        def hand(t, wrench):
            half = 0.5 * (angle + rate * t)
            q = np.sign(np.cos(half)) * np.array([np.sin(half), 0, 0, np.cos(half)])
            place = {"position": AWAY + [0.1 * t, 0, 0], "quaternion": q, "buttons": 5}
            return place if t < 0.3 else None

        first, *steps = hapticd.lockstep(CONFIG, hand)
        self.assertEqual(first.servo["device"]["V_BH"]["v"].tolist(), [0, 0, 0])
        for step in steps:
            device = step.servo["device"]
            np.testing.assert_allclose(device["V_BH"]["v"], [0.1, 0, 0], atol=1e-9)
            np.testing.assert_allclose(device["V_BH"]["w"], [rate, 0, 0], atol=1e-9)
            self.assertEqual((device["buttons"], step.servo["fault"]), (5, 0))

    def test_a_velocity_that_is_said_is_taken(self):
        def hand(t, wrench):
            said = {"position": AWAY, "velocity": [0.1, 0.2, 0.3], "angular_velocity": (1, 2, 3)}
            return said if t < 0.01 else None

        *_, last = hapticd.lockstep(CONFIG, hand)
        self.assertEqual(last.servo["device"]["V_BH"]["v"].tolist(), [0.1, 0.2, 0.3])
        self.assertEqual(last.servo["device"]["V_BH"]["w"].tolist(), [1, 2, 3])

    def test_a_hand_that_is_nowhere_is_flagged_and_felt_as_zero(self):
        for nowhere in ([np.nan] * 3, [0, -np.inf, 0], [0, 0, 1e300], [1e6, 0, 0]):
            pulling, forces = PullingHand([0, 0, TOP - 0.02], 0.8), []

            def hand(t, wrench):
                forces.append(np.linalg.norm(wrench))
                place = pulling(t, wrench)
                said = nowhere if abs(t - 0.7) < 1e-9 else place
                return None if place is None else {"position": said, "velocity": pulling.v}

            for step in hapticd.lockstep(CONFIG, hand):
                if step.t < 0.6995:
                    self.assertEqual(step.servo["fault"], Fault.NONE)
                    continue
                self.assertEqual(step.servo["fault"], Fault.DEVICE_NOT_FINITE)
                self.assertTrue(ServoFlag(int(step.servo["flags"])) & ServoFlag.FAULT)
                self.assertEqual(step.servo["F_device_B"]["f"].tolist(), [0, 0, 0])
            self.assertGreater(forces[700], 2.0)
            self.assertEqual((max(forces[701:]), len(forces)), (0.0, 801))

    def test_a_mistake_in_the_file_is_one_line(self):
        wrong = {**CONFIG, "coupling": {"stiffness": "800 kg"}}
        for config, renderer, words in (
            (wrong, None, r"session\.toml:8:\d+: 'stiffness'"),
            ("no-such-file", None, "no-such-file"),
            (CONFIG, "touch", "no renderer 'touch'|'touch'"),
            (ROOT / "configs" / "admittance.toml", None, "admittance"),
        ):
            with self.assertRaisesRegex(hapticd.Error, words) as caught:
                next(hapticd.lockstep(config, lambda t, wrench: AWAY, renderer=renderer))
            self.assertRegex(str(caught.exception), r"\Ahaptic-lockstep: [^\n]+\Z")

    def test_a_real_device_need_not_be_armed(self):
        config = {**CONFIG, "device": {"kind": "woodenhaptics", "serial": {"path": "/dev/nowhere"}}}
        *_, last = hapticd.lockstep(config, PullingHand([0, 0, TOP - 0.02], 1.5))
        self.assertAlmostEqual(last.servo["F_device_B"]["f"][2], 3.2, delta=0.01)

    def test_what_hand_returns_is_checked(self):
        for place, words in (
            ([0, 0], r"^hand: position: shape \(2,\), wanted \(3,\) \[m\]$"),
            ("here", r"^hand: position: no numbers; wanted \(3,\) \[m\]$"),
            ({"position": AWAY, "quaternion": [1, 0, 0]}, r"^hand: quaternion: shape \(3,\), wanted"),
            ({"position": AWAY, "speed": AWAY}, r"^hand: 'speed' is not known; there are position, "),
            ({"quaternion": [0, 0, 0, 1]}, r"^hand: a position is missing; there are position, "),
        ):
            with self.assertRaisesRegex(ValueError, words):
                next(hapticd.lockstep(CONFIG, lambda t, wrench: place))

    def test_it_ends_with_what_the_script_does(self):
        def hand(t, wrench):
            if t > 0.005:
                raise KeyError("mine")
            return AWAY

        with self.assertRaisesRegex(KeyError, "mine"):
            for _ in hapticd.lockstep(CONFIG, hand):
                self.assertEqual(len(children()), 1)
        self.assertEqual(children(), [])
        with self.assertRaises(KeyboardInterrupt):
            for step in hapticd.lockstep(CONFIG, lambda t, wrench: AWAY):
                if step.t > 0.005:
                    signal.raise_signal(signal.SIGINT)
        self.assertEqual(children(), [])
        for _ in hapticd.lockstep(CONFIG, lambda t, wrench: AWAY):
            break

    def test_a_program_that_dies_is_an_error(self):
        def hand(t, wrench):
            if t > 0.005:
                os.kill(children()[0], signal.SIGKILL)
            return AWAY

        with self.assertRaisesRegex(hapticd.Error, r"^haptic-lockstep ended without a word \(exit code -9\)$"):
            for _ in hapticd.lockstep(CONFIG, hand):
                pass

    def test_a_program_of_another_version_is_refused(self):
        with unittest.mock.patch.dict(os.environ, HAPTICD_BIN=f"{self.folder.name}/hapticd"):
            program = Path(self.folder.name, "haptic-lockstep")
            with self.assertRaisesRegex(hapticd.Error, r"/haptic-lockstep is not there; install "):
                next(hapticd.lockstep(CONFIG, lambda t, wrench: AWAY))
            program.write_text('#!/bin/sh\necho \'{"abi": 3}\'\nexec cat\n')
            program.chmod(0o755)
            with self.assertRaisesRegex(hapticd.Error, r"layout 3, this module reads \d+; install "):
                next(hapticd.lockstep(CONFIG, lambda t, wrench: AWAY))

    def test_a_child_by_fork_leaves_it_running(self):
        steps = hapticd.lockstep(CONFIG, lambda t, wrench: AWAY)
        next(steps)
        child = os.fork()
        if child == 0:
            warnings.simplefilter("ignore")  # of the parent's program, which runs
            steps.close()
            os._exit(0)
        self.assertEqual(os.waitpid(child, 0)[1], 0)
        self.assertEqual(len([name for name in os.listdir(self.folder.name) if name.startswith("hapticd-")]), 1)
        self.assertAlmostEqual(next(steps).t, 0.001)
        steps.close()

    def test_the_example_measures_the_wall(self):
        example = ROOT / "clients/python/examples/02_lockstep.py"
        done = subprocess.run([sys.executable, example], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        rows = [[float(word) for word in line.split()] for line in done.stdout.splitlines()[1:]]
        self.assertEqual([row[0] for row in rows], list(range(9)))
        for depth, *forces in rows:
            for force in forces:  # [N] of [mm]; the session's max_force is 6 N
                self.assertAlmostEqual(force, min(1e-3 * WALL * depth, 6), delta=2e-3)


class Bytes(unittest.TestCase):
    """What the program reads and writes, without the package's own reader."""

    def run_program(self, data, config="plane"):
        words = [PROGRAM, ROOT / "configs" / f"{config}.toml"]
        return subprocess.run(words, input=data, capture_output=True)

    def sample(self, p=(0.0, 0.0, 0.1), flags=0b1000101):
        return struct.pack("<q20d2I", 0, *p, 0, 0, 0, 1, *[0] * 13, 0, flags)

    def records(self, out):
        """Bytes of each record, after the line of JSON."""
        line, _, rest = out.partition(b"\n")
        head = json.loads(line)
        self.assertEqual(head, {"abi": hapticd.abi, "period_ns": 10**6, "servo_rate": 1000, "t_ns": 10**9})
        found = []
        while rest:
            n, zero = struct.unpack_from("<2I", rest)
            self.assertEqual(zero, 0)
            self.assertGreaterEqual(len(rest), 8 + 8 * n)
            found.append(rest[8 : 8 + 8 * n])
            rest = rest[8 + 8 * n :]
        return found

    def test_three_records_a_sample(self):
        self.assertEqual(self.records(self.run_program(b"").stdout), [])
        done = self.run_program(5 * self.sample())
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        records = self.records(done.stdout)
        ticks = [struct.unpack_from("<2q", record) for record in records[::3]]
        self.assertEqual(ticks, [(i, 10**9 + i * 10**6) for i in range(5)])
        # each has its fixed fields and as many lists as it has (docs/wire.md)
        self.assertEqual((len(records), len(records[1])), (15, 888 + 6 * 8))

    def test_half_a_sample_is_an_error(self):
        done = self.run_program(self.sample() + self.sample()[:100])
        self.assertEqual((done.returncode, len(self.records(done.stdout))), (2, 3))
        self.assertRegex(done.stderr, rb"^haptic-lockstep: standard input ends 100 bytes after [^\n]+\n$")

    def test_a_sample_that_has_ended_ends_it(self):
        done = self.run_program(self.sample() + self.sample(flags=0b1010101) + self.sample())
        self.assertEqual((done.returncode, len(self.records(done.stdout))), (0, 3))

    def test_output_that_nobody_takes_ends_it(self):
        with open("/dev/full", "wb") as full:
            done = subprocess.run([PROGRAM, ROOT / "configs/plane.toml"], input=b"", stdout=full,
                                  stderr=subprocess.PIPE)  # fmt: skip
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, rb"^haptic-lockstep: standard output cannot be written[^\n]+\n$")

    def test_no_bytes_make_a_force_that_is_not_finite(self):
        dice = random.Random(7)
        numbers = [0.0, -0.0, 1e-308, 1e308, -1e300, float("inf"), float("nan"), 1e9, 0.03, -0.039]
        for config in ("plane", "heap", "rigid-peg"):
            data = b""
            for i in range(300):
                if i % 3 == 0:
                    sample = dice.randbytes(176)
                elif i % 3 == 1:
                    sample = self.sample([dice.choice(numbers) for _ in range(3)])
                else:
                    sample = self.sample([dice.uniform(-0.06, 0.06) for _ in range(3)])
                flags = dice.getrandbits(32) & ~0b10000 if i % 2 else 0b1000101
                data += sample[:172] + struct.pack("<I", flags)
            done = self.run_program(data, config)
            self.assertEqual((done.returncode, done.stderr), (0, b""), config)
            records = self.records(done.stdout)
            self.assertEqual(len(records), 900, config)
            for frame in records[::3]:
                force = np.frombuffer(frame, "<f8", 6, 544)
                self.assertTrue(np.isfinite(force).all() and np.linalg.norm(force[:3]) < 8.001, config)


if __name__ == "__main__":
    unittest.main()
