# SPDX-License-Identifier: GPL-3.0-or-later
# Judges a CSV of /servo0/frame: awk -f judge.awk -v kind=KIND FILE. Each tick without a fresh sample is
# explained by the time since the last one: exchanges take longer than a tick, or the guest or its host
# stood still. A device that is lost, stale or noisy is not.
BEGIN {FS = ","; fresh_flag = 1; lost_flag = 256; stale_flag = 512; noisy_flag = 1024}
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
{
  ++ticks
  flags = $column["device.flags"]
  if (has(flags, fresh_flag)) ++fresh
  if (has(flags, stale_flag) || has(flags, noisy_flag)) ++doubted
  if (has(flags, lost_flag)) ++lost
  x = $column["F_device_B.force.x_N"]; y = $column["F_device_B.force.y_N"]; z = $column["F_device_B.force.z_N"]
  force = x * x + y * y + z * z
  if (force > most) most = force
  if ($column["n_contacts"] > 0) ++contact
  skipped = $column["skipped"]
  if (NR == 2) skipped_before = skipped
  late = $column["wake_late_ns"] / 1e6
  if (late > latest) latest = late
}
END {
  good = ticks > 0 && fresh > ticks / 20 && doubted == 0 && (most > 0.25 || kind == "spacemouse") && contact > 0
  printf "result %s %s: %d ticks, %d skipped, %d fresh samples, %d ticks lost, %d doubted, ", kind,
    good ? "passed" : "FAILED", ticks, skipped - skipped_before, fresh, lost, doubted
  printf "contact in %d, force to %.2f N, latest wake-up %.1f ms\n", contact, root(most), latest
}
