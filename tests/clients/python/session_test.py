# SPDX-License-Identifier: GPL-3.0-or-later
"""Sessions that run: they are read, changed and given to."""

import gc
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
import unittest
import warnings
from pathlib import Path

import hapticd
import numpy as np

ROOT = Path(__file__).resolve().parents[3]
CONFIGS = ROOT / "configs"
GIVE = tomllib.loads((CONFIGS / "give.toml").read_text())


def give_three():
    """The ball, and two more with clients of their own: a place is kept for a second after its
    client has left."""
    names = ["ball", "second", "third"]
    return {
        **GIVE,
        "object": [
            {**GIVE["object"][0], "name": name, "position": [f"{200 * i} mm", "0 m", "0 m"]}
            for i, name in enumerate(names)
        ],
        "client": [{**GIVE["client"][0], "name": name, "may": [f"move {name}"]} for name in names],
    }


class Sessions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="py")  # short: sockets lie in it
        os.environ["HAPTICD_RUNTIME_DIR"] = cls.folder
        cls.session = hapticd.run(GIVE)

    @classmethod
    def tearDownClass(cls):
        cls.session.close()
        left = [name for name in os.listdir(cls.folder) if name.endswith(".sock")]
        shutil.rmtree(cls.folder)
        assert not left, left

    def test_every_tick_while_others_run(self):
        # HAPTIC_TORTURE_SCALE=40: 60 s, and what reading them takes of a core
        scale = float(os.environ.get("HAPTIC_TORTURE_SCALE", 1))
        seconds = 1.5 * scale
        turns = [0]
        stop = threading.Event()

        def others():
            while not stop.wait(0.001):
                turns[0] += 1

        frames = self.session.servo()
        out = frames.empty(64)
        ticks, lost, most = [], 0, 0.0
        thread = threading.Thread(target=others, daemon=True)
        thread.start()
        end, before = time.monotonic() + seconds, time.thread_time()
        while time.monotonic() < end:
            self.assertTrue(frames.wait(1))
            n, n_lost = frames.next(out)
            ticks += out["tick"][:n].tolist()
            lost += n_lost
            most = max(most, float(np.linalg.norm(out["F_device_B"]["f"][:n], axis=1).max(initial=0)))
        share = (time.thread_time() - before) / seconds
        stop.set()
        thread.join()
        if scale > 1:
            print(f"{len(ticks)} ticks in {seconds} s, {lost} lost, {share:.1%} of a core")
        skipped = int(out["skipped"][0])
        self.assertEqual(lost, 0)
        self.assertEqual(len(set(ticks)), len(ticks))
        self.assertGreaterEqual(len(ticks) + skipped, 970 * seconds)
        self.assertLessEqual(np.diff(ticks).max(), 1 + skipped)
        self.assertGreater(most, 0.3)
        self.assertGreater(turns[0], 500 * seconds)

    def test_what_is_not_taken_waits(self):
        frames = self.session.sim()
        out = frames.empty(10)
        frames.wait(1)
        begin = frames.next(out)[0]
        time.sleep(0.3)
        n, lost = frames.next(out)
        self.assertEqual((n, lost, frames.lost), (10, 0, 0))  # the rest waits
        self.assertGreater(begin, 0)
        self.assertEqual(np.diff(out["seq"]).tolist(), [1] * 9)
        self.assertEqual(len(frames.objects(0)), 1)
        self.assertEqual(len(frames.objects(9)), 1)
        with self.assertRaises(IndexError):
            frames.objects(10)
        newest = frames.latest()
        self.assertGreater(newest["seq"], out["seq"][9])
        self.assertEqual(frames.lost, 0)

    def test_latest_is_kept(self):
        frames = self.session.control()
        one = frames.latest()
        self.assertEqual(one["translational_stiffness"], frames.latest()["translational_stiffness"])
        self.session.set("stiffness", "800 N/m")
        for _ in range(5):
            self.assertTrue(frames.wait(1))
            if frames.latest()["translational_stiffness"] == 800:
                break
        self.assertEqual(frames.latest()["translational_stiffness"], 800)
        self.assertEqual(frames.dtype.names[0], "revision")

    def test_contacts_are_near_the_tool(self):
        frames = self.session.contact()
        for _ in range(400):
            frames.wait(1)
            frames.latest()
            if len(frames.contacts()) > 0:
                break
        contact = frames.contacts()[0]
        self.assertAlmostEqual(float(np.linalg.norm(contact["normal_O"])), 1, places=9)
        self.assertAlmostEqual(float(np.linalg.norm(contact["object_point_O"])), 0.02, places=3)

    def test_out_is_checked(self):
        frames = self.session.servo()
        for out in (np.zeros(3), np.zeros(3, hapticd.dtype("SceneFrame")), frames.empty(6)[::2],
                    frames.empty(4).reshape(2, 2)):
            with self.assertRaisesRegex(ValueError, "^out: "):
                frames.next(out)
        self.assertEqual(frames.next(frames.empty(0)), (0, 0))

    def test_commands_and_their_refusals(self):
        s = hapticd.connect()
        self.assertEqual(s.name, self.session.name)
        s.pause()
        self.assertTrue(s.status()["paused"])
        s.resume()
        s.arm()
        self.assertTrue(s.status()["armed"])
        for call, words in (
            (lambda: s.set("stiffness", "1 kg"), 'stiffness: "1 kg" is a mass'),
            (lambda: s.set("stifness", "1 N/m"), "stif"),
            (lambda: hapticd.connect("nobody"), "no session 'nobody'"),
            (lambda: s.give("nobody"), "nobody"),
            (lambda: s.servo(4), "hands are 0 to 3"),
            (lambda: hapticd.run({"session": {"name": "x"}}), "device"),
        ):
            with self.assertRaisesRegex(hapticd.Error, words) as caught:
                call()
            self.assertNotIn("\n", str(caught.exception))

    def test_ctrl_c_ends_a_wait(self):
        frames = self.session.servo(1)  # a hand that is not there
        threading.Timer(0.1, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        begin = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            frames.wait()
        self.assertLess(time.monotonic() - begin, 1)

    def test_a_recording_of_a_session(self):
        path = os.path.join(self.folder, "a.mcap")
        hapt = Path(os.environ["HAPTICD_BIN"]).with_name("hapt")
        subprocess.run([hapt, "record", "-o", path, "--for", "0.25s", "--session", self.session.name],
                       check=True, capture_output=True)  # fmt: skip
        log = hapticd.open_log(path)
        self.assertEqual(tomllib.loads(log.session_file), GIVE)
        self.assertGreater(len(log["/servo0/frame"]), 200)
        self.assertEqual(log["/servo0/frame"].pushes(0).dtype, hapticd.dtype("ObjectPush"))


class Giving(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="py")
        os.environ["HAPTICD_RUNTIME_DIR"] = cls.folder
        cls.session = hapticd.run(give_three())

    @classmethod
    def tearDownClass(cls):
        cls.session.close()
        shutil.rmtree(cls.folder)

    def place(self):
        scene = self.session.sim()
        scene.wait(1)
        scene.latest()
        return scene.objects()["X_WO"]["p"][0]

    def test_a_ball_is_pushed_and_moves(self):
        far, pushed, seen = 0.0, 0.0, 0.0
        p, v = np.zeros(3), np.zeros(3)
        with self.session.give("ball") as g:
            ball = g.object("ball")
            for period in g.every(0.01):
                push = g.pushed(ball)
                n = max(1, round(push.span / 1e-3))
                for i in range(n):
                    own = -200 * p - 0.5 * v
                    v += push.span / n * (own + push.at((i + 0.5) * push.span / n)[:3]) / 0.1
                    p += push.span / n * v
                g.move(ball, position=p, velocity=v, acceleration=(-200 * p - 0.5 * v) / 0.1,
                       mass=0.1, stiffness=200, damping=0.5)  # fmt: skip
                g.publish()
                far = max(far, float(np.linalg.norm(p)))
                pushed += float(np.linalg.norm(push.impulse[:3]))
                if period.index == 80:
                    seen = float(np.linalg.norm(self.place() - p))
                if period.index >= 100:
                    break
            self.assertEqual(self.session.status()["giving"][0]["refused"], 0)
            self.assertGreater(far, 2e-3)
            self.assertGreater(pushed, 0.01)
            self.assertLess(seen, 5e-3)
        self.assertFalse(g.is_connected)
        with self.assertRaisesRegex(hapticd.Error, "'ball' has left"):
            g.publish()

    def test_arguments_are_checked(self):
        with self.session.give("second") as g:
            g.pushed("second")
            for more, words in (
                ({"position": (0, 0)}, r"^position: shape \(2,\), wanted \(3,\) \[m\]$"),
                ({"position": "x"}, "^position: no numbers"),
                ({"velocity": (0, 0, np.nan)}, "^velocity: not finite"),
                ({"quaternion": (1, 1, 0, 0)}, "^quaternion: length 1.414, must be 1"),
                ({"rotation": -np.eye(3)}, "^rotation: the matrix"),
                ({"rotation": np.eye(3), "quaternion": (0, 0, 0, 1)}, "not both"),
                ({"mass": 0}, "^mass: 0.0 kg"),
                ({"mass": 1, "mobility": 1}, "not both"),
                ({"stiffness": np.ones((2, 2))}, r"^stiffness: shape \(2, 2\), wanted a number or \(3"),
                ({"stiffness": -1}, r"^stiffness: has a negative direction \[N/m\]$"),
                ({"damping": np.triu(np.ones((3, 3)))}, "^damping: not symmetric"),
            ):
                with self.assertRaisesRegex(ValueError, words) as caught:
                    g.move("second", **{"position": (0, 0, 0), **more})
                self.assertNotIn("\n", str(caught.exception))
            with self.assertRaisesRegex(hapticd.Error, "did you mean 'second'"):
                g.object("secnd")
            tool = g.tool()
            self.assertEqual((tool["p"].shape, tool["q"].shape), ((3,), (4,)))
            for call, words in (
                (lambda: g.push((1, 2), at=tool), r"^force: shape \(2,\), wanted \(3,\) \[N\]$"),
                (lambda: g.push((1, 0, 0), at=(0, 0, 0)), "^at: no pose; pass what tool"),
                (lambda: g.push((1, 0, 0), at=tool, damping=-1), "^damping: has a negative direction"),
                (lambda: g.push((1, 0, 0), at=tool, trust=-1), "^trust: -1.0 m, must not be below 0 m$"),
                (lambda: g.touch((0, 0, 0), (0, 0, 2)), "^normal: length 2, must be 1$"),
            ):
                with self.assertRaisesRegex(ValueError, words) as caught:
                    call()
                self.assertNotIn("\n", str(caught.exception))
            with self.assertRaisesRegex(hapticd.Error, "^touch: more than 24 planes"):
                for _ in range(25):
                    g.touch((0, 0, 0), (0, 0, 1))

    def test_rotations_become_quaternions(self):
        rng = np.random.default_rng(1)
        for _ in range(200):
            q = rng.normal(size=4)
            q /= np.linalg.norm(q)
            x, y, z, w = q
            R = np.array([
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ])  # fmt: skip
            ours = hapticd.giver._quaternion_of(R)
            self.assertAlmostEqual(abs(float(ours @ q)), 1, places=12)

    def test_a_child_by_fork_is_refused_and_holds_no_place(self):
        frames = self.session.servo()
        frames.wait(1)
        with self.session.give("third") as g:
            g.pushed("third")
            said, say = os.pipe()
            child = os.fork()
            if child == 0:
                for call in (frames.latest, lambda: frames.wait(1), lambda: g.pushed("third")):
                    try:
                        call()
                    except hapticd.Error as error:
                        os.write(say, f"{error}\n".encode())
                del frames, g
                gc.collect()
                os.write(say, b"end\n")
                time.sleep(60)  # longer than the parent gives
                os._exit(0)
            os.close(say)
            text = b""
            while not text.endswith(b"end\n"):
                text += os.read(said, 1000)
            self.assertEqual(text.count(b"does not survive fork()"), 3, text)
            self.assertEqual(self.session.status()["giving"][2]["pid"], os.getpid())
        time.sleep(0.1)
        self.assertEqual(self.session.status()["giving"][2]["pid"], -1)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        self.assertTrue(frames.wait(1))

    def test_every_keeps_its_grid(self):
        periods = []
        for period in hapticd.every(0.01):
            periods.append(period)
            if len(periods) == 3:
                time.sleep(0.035)
            if period.index >= 20:
                break
        self.assertGreaterEqual(periods[-1].skipped, 2)
        self.assertEqual(periods[-1].index, len(periods) - 1 + periods[-1].skipped)
        with self.assertRaisesRegex(ValueError, "^period: 0 s"):
            next(hapticd.every(0))


class Restarts(unittest.TestCase):
    def test_it_attaches_again_and_ends_with_the_session(self):
        with tempfile.TemporaryDirectory(prefix="py") as folder:
            os.environ["HAPTICD_RUNTIME_DIR"] = folder
            program = [hapticd.find_hapticd(), str(CONFIGS / "plane.toml")]
            quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
            first = subprocess.Popen(program, **quiet)
            for _ in hapticd.every(0.05):
                try:
                    frames = hapticd.connect("plane").servo()
                    break
                except hapticd.Error:
                    pass
            self.assertTrue(frames.wait(10))
            out = frames.empty(5000)
            frames.next(out)
            first.kill()
            first.wait()
            while frames.wait(0.3):
                frames.next(out)
            self.assertFalse(frames.is_connected)
            second = subprocess.Popen(program, **quiet)
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                self.assertTrue(frames.wait(10))
            self.assertEqual((frames.restarts, [w.category for w in caught]), (1, [hapticd.Missed]))
            self.assertGreater(frames.missed, 0.25)
            self.assertEqual(caught[0].filename, __file__)
            self.assertGreater(frames.next(out)[0], 0)
            second.terminate()
            second.wait()
            while frames.wait(5):
                frames.next(out)
            self.assertTrue(frames.ended)
            self.assertIsNotNone(frames.latest())

    def test_a_session_ends_with_its_script(self):
        with tempfile.TemporaryDirectory(prefix="py") as folder:
            os.environ["HAPTICD_RUNTIME_DIR"] = folder
            script = "import hapticd, os; s = hapticd.run(%r); os.kill(os.getpid(), 9)"
            subprocess.run([sys.executable, "-c", script % str(CONFIGS / "plane.toml")], check=False)
            for _ in range(100):
                if not any(name.endswith(".sock") for name in os.listdir(folder)):
                    break
                time.sleep(0.05)
            self.assertFalse([name for name in os.listdir(folder) if name.endswith(".sock")])


def started(*names):
    return [
        subprocess.Popen(
            [sys.executable, ROOT / "clients/python/examples" / name],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )
        for name in names
    ]  # fmt: skip


class Examples(unittest.TestCase):
    def check_ended(self, examples, *words):
        """The session has ended, so they end."""
        for example, word in zip(examples, words):
            said, error = example.communicate(timeout=5)
            self.assertEqual((example.returncode, error), (0, ""))
            self.assertIn(word, said)

    def test_the_arm_is_pushed_and_swings(self):
        with tempfile.TemporaryDirectory(prefix="py") as folder:
            os.environ["HAPTICD_RUNTIME_DIR"] = folder
            with hapticd.run(CONFIGS / "robot.toml") as s:
                examples = started("01_watch.py", "04_your_robot.py")
                scene, far = s.sim(), 0.0
                begin = time.monotonic()
                while time.monotonic() < begin + (0.7 if far > 2e-3 else 5):
                    scene.wait(1)
                    scene.latest()
                    far = max(far, float(np.linalg.norm(scene.objects()["X_WO"]["p"][0])))
                self.assertEqual(s.status()["giving"][0]["refused"], 0)
            self.check_ended(examples, "tool ", "joints ")
            self.assertGreater(far, 2e-3)

    def test_a_charge_pulls_and_a_landscape_is_touched(self):
        with tempfile.TemporaryDirectory(prefix="py") as folder:
            os.environ["HAPTICD_RUNTIME_DIR"] = folder
            with hapticd.run(CONFIGS / "field.toml") as s:
                examples = started("05_field.py", "06_your_collision.py")
                servo, contact = s.servo(), s.contact()
                worst, pulled, lay = 0.0, 0, 0
                begin = time.monotonic()
                while time.monotonic() < begin + 4:
                    servo.wait(1)
                    frame, felt = servo.latest(), servo.felt()
                    p = frame["X_WT"]["p"]
                    r = float(np.linalg.norm(p))
                    for of in felt:
                        F = of["F_W"]["f"]
                        if of["client"] == 1:
                            lay += bool(np.linalg.norm(F) > 0.05)
                        elif r > 0.03 and of["share"] == 1 and np.linalg.norm(F) > 0:
                            pulled += 1
                            wanted = -2e-3 / r**3 * p
                            if time.monotonic() > begin + 2:
                                worst = max(worst, float(np.linalg.norm(F - wanted)))
                contact.wait(1)
                contact.latest()
                self.assertEqual(contact.givers()["refused"].tolist(), [0, 0])
            self.check_ended(examples, "charge", "ground")
            self.assertGreater(pulled, 50)
            self.assertGreater(lay, 50)
            self.assertLess(worst, 0.2)


if __name__ == "__main__":
    unittest.main()
