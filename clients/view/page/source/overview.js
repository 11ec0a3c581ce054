// SPDX-License-Identifier: GPL-3.0-or-later
// The overview of a recording as lines of a plot.

import { kQuantities } from "./layout.js";

/**
 * Of {time: […], columns: [{name, QUANTITY: {min: […], max: […]}}]} a table [times, …quantities] for
 * each column. A step becomes two points, its least and its greatest value, so that a line through
 * them fills what the samples between covered.
 */
export function tables_of({ time, columns }) {
  const half = time.length > 1 ? (time[1] - time[0]) / 2 : 0;
  const times = time.flatMap((t) => [t, t + half]);
  return columns.map((column) => [
    times,
    ...kQuantities.map((name) => {
      const { min = [], max = [] } = column[name] ?? {};
      return time.flatMap((_, i) => [min[i] ?? null, max[i] ?? null]);
    }),
  ]);
}
