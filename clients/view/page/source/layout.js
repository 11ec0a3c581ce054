// SPDX-License-Identifier: GPL-3.0-or-later
// Decodes a binary frame (float64 only) by the table of /layout.json. No offset is known here.

/** The fields of a record at `base`: a number where one is stored, else a view of `count` numbers. */
export function read_record(numbers, base, fields) {
  const record = {};
  for (const [name, place] of Object.entries(fields)) {
    if (!Array.isArray(place)) continue; // `size`
    const [offset, count] = place;
    record[name] =
      count === 1 ? numbers[base + offset] : numbers.subarray(base + offset, base + offset + count);
  }
  return record;
}

function read_list(numbers, base, count, kind) {
  const list = [];
  for (let i = 0; i < count; i += 1) list.push(read_record(numbers, base + i * kind.size, kind));
  return list;
}

/**
 * Frame of an ArrayBuffer: the fixed fields by name, `objects`, `contacts`, `joints`, and `samples`,
 * which stays packed: {numbers, base, count}. Throws a RangeError where the length does not fit.
 */
export function decode_frame(buffer, layout) {
  if (buffer.byteLength % 8 !== 0 || buffer.byteLength < 8 * layout.fixed_size) {
    throw new RangeError(`a frame of ${buffer.byteLength} bytes is no frame of this bridge`);
  }
  const numbers = new Float64Array(buffer);
  const frame = read_record(numbers, 0, layout.fixed);
  const at_objects = layout.fixed_size;
  const at_contacts = at_objects + frame.n_objects * layout.object.size;
  const at_joints = at_contacts + frame.n_listed * layout.contact.size;
  const at_samples = at_joints + frame.n_joints * layout.joint.size;
  const end = at_samples + frame.n_samples * layout.sample.size;
  if (end !== numbers.length) {
    throw new RangeError(`a frame of ${numbers.length} numbers, where its counts ask for ${end}`);
  }
  frame.objects = read_list(numbers, at_objects, frame.n_objects, layout.object);
  frame.contacts = read_list(numbers, at_contacts, frame.n_listed, layout.contact);
  frame.joints = read_list(numbers, at_joints, frame.n_joints, layout.joint);
  frame.samples = { numbers, base: at_samples, count: frame.n_samples };
  return frame;
}

/** The quantities that are plotted, in the order of the columns of a History. */
export const kQuantities = [
  "force_x",
  "force_y",
  "force_z",
  "force",
  "torque_x",
  "torque_y",
  "torque_z",
  "torque",
  "depth",
  "wake_late",
  "contact_rate",
];

/** Calls row(time, values) for each packed sample; `values` (kQuantities) is reused. */
export function each_sample(samples, kind, row) {
  const { numbers, base, count } = samples;
  const values = new Array(kQuantities.length);
  for (let i = 0; i < count; i += 1) {
    const at = base + i * kind.size;
    for (const [first, place] of [
      [0, kind.force[0]],
      [4, kind.torque[0]],
    ]) {
      const [x, y, z] = [numbers[at + place], numbers[at + place + 1], numbers[at + place + 2]];
      values[first] = x;
      values[first + 1] = y;
      values[first + 2] = z;
      values[first + 3] = Math.hypot(x, y, z);
    }
    values[8] = numbers[at + kind.depth[0]];
    values[9] = numbers[at + kind.wake_late[0]];
    values[10] = numbers[at + kind.contact_rate[0]];
    row(numbers[at + kind.time[0]], values);
  }
}
