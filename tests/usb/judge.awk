# SPDX-License-Identifier: GPL-3.0-or-later
# Judges a CSV of /servo0/frame: awk -f judge.awk -v kind=KIND [-v away=SECONDS] FILE.
#
# An exchange that is lost is made again after 5 ms, so that every two samples that are less than
# 6 ms apart prove that none was lost between them. A longer gap is explained where the servo's own
# ticks between them were late or skipped: then the guest stood still. Any other must not be longer
# than the host stood still, which only the host knows: the line "gaps" is for it. A SpaceMouse at
# rest says nothing, and is not asked.
#
# With `away` the device was unplugged for so long, and the gap without it is judged: noticed within
# 20 ms of the last sample, back within 3 s of its return, and no step of the force then but what
# the hand's own motion makes and a guest that is too slow: without the soft start it were 2 N, the
# slew of a tick. `falcon: away for a second` (tests/clients/lab) has the exact figure.
BEGIN {FS = ","; fresh_flag = 1; lost_flag = 256; stale_flag = 512; noisy_flag = 1024; fault_flag = 256; no_device_flag = 1048576}
NR == 1 {
  for (i = 1; i <= NF; ++i) column[$i] = i
  next
}
# busybox has no square root: Newton's method
function root(square,   guess, i) {
  guess = 1
  for (i = 0; i < 30; ++i) guess = (guess + square / guess) / 2
  return square > 0 ? guess : 0
}
function has(flags, flag) {return int(flags / flag) % 2 == 1}
function end_gap(t,   gap) {
  gap = (t - sampled) / 1e6
  if (sampled > 0 && gap > 6 && kind != "spacemouse") {
    if (was_late) ++explained
    else {++unexplained; if (gap > longest) longest = gap}
  }
  sampled = t
  was_late = 0
}
{
  ++ticks
  t = $column["t_ns"]
  flags = $column["device.flags"]
  skipped = $column["skipped"]
  late = $column["wake_late_ns"] / 1e6
  if (NR == 2) skipped_before = skipped_last = skipped
  if (skipped != skipped_last || late > 1) was_late = 1
  skipped_last = skipped
  if (late > latest) latest = late
  if (has(flags, fresh_flag)) {++fresh; end_gap($column["device.t_ns"])}
  if (has(flags, stale_flag) || has(flags, noisy_flag)) ++doubted
  x = $column["F_device_B.force.x_N"]; y = $column["F_device_B.force.y_N"]; z = $column["F_device_B.force.z_N"]
  force = root(x * x + y * y + z * z)
  if (force > most) most = force
  if ($column["n_contacts"] > 0) ++contact
  # of the device that is away, the longest time that it was lost
  if (has(flags, lost_flag)) {
    ++lost
    if (!since) {since = t; noticed = (t - sampled) / 1e6; noticed_late = was_late}
  } else if (since && has(flags, fresh_flag)) {
    if (t - since > time_lost) {time_lost = t - since; found = noticed; found_late = noticed_late; back = t; step = felt = ready = 0}
    since = 0
  }
  px = $column["device.X_BH.position.x_m"]; py = $column["device.X_BH.position.y_m"]; pz = $column["device.X_BH.position.z_m"]
  # from one tick to the next: of those that were skipped nobody knows
  if (back && t > back && $column["tick"] == tick + 1) {
    moved = root((px - qx) * (px - qx) + (py - qy) * (py - qy) + (pz - qz) * (pz - qz))
    grown = force - force_before - moved * $column["translational_stiffness_N_per_m"]
    if (grown > step) step = grown
  }
  if (back && t > back) {
    if (force > felt) felt = force
    if (!has($column["flags"], no_device_flag) && !has($column["flags"], fault_flag)) ready = 1
  }
  tick = $column["tick"]
  qx = px; qy = py; qz = pz
  force_before = force
}
END {
  if (away) {
    after = time_lost / 1e9 - away
    good = ready && time_lost > 0 && after < 3 && (found <= 20 || found_late) && step < 1 && (felt > 0.25 || kind == "spacemouse")
    printf "result %s %s: unplugged, lost %.1f ms after its last sample%s, back %.2f s after its return, ", kind,
      good ? "passed" : "FAILED", found, (found > 20) ? " (the servo was late)" : "", after
    printf "then force to %.2f N with steps of at most %.2f N\n", felt, step
    exit
  }
  good = ticks > 0 && fresh > ticks / 20 && doubted == 0 && (most > 0.25 || kind == "spacemouse") && contact > 0
  printf "result %s %s: %d ticks, %d skipped, %d fresh samples, %d ticks lost, %d doubted, ", kind,
    good ? "passed" : "FAILED", ticks, skipped - skipped_before, fresh, lost, doubted
  printf "contact in %d, force to %.2f N, latest wake-up %.1f ms\n", contact, most, latest
  printf "gaps %s late_ticks=%d others=%d longest_ms=%d latest_wake_ms=%d\n", kind, explained, unexplained, longest + 0.999, latest + 0.999
}
