// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0
"use strict";

// Traces of the figure of residual vectors. A view holds rows (u, v, du, dv) in pixels.
const arrows = (() => {
  const BARB = 0.3;
  const MOST = 0.12; // longest arrow of a point that was left out, as a share of the image's width

  function rows(packed) {
    const bytes = Uint8Array.from(atob(packed.bdata), (character) => character.charCodeAt(0));
    const numbers = new Float32Array(bytes.buffer);
    return Array.from({ length: numbers.length / 4 }, (_, k) => Array.from(numbers.subarray(4 * k, 4 * k + 4)));
  }

  // A line from (u, v) along (du, dv) with two barbs, then a gap.
  function path(xs, ys, u, v, du, dv) {
    const [x, y] = [u + du, v + dv];
    const barb = (side) => [x - BARB * (0.9 * du - side * 0.5 * dv), y - BARB * (0.9 * dv + side * 0.5 * du)];
    const [left, right] = [barb(1), barb(-1)];
    xs.push(u, x, left[0], x, right[0], null);
    ys.push(v, y, left[1], y, right[1], null);
  }

  function lines(points, enlargement, longest, colour) {
    const [x, y] = [[], []];
    for (const [u, v, du, dv] of points) {
      const length = enlargement * Math.hypot(du, dv);
      const factor = enlargement * Math.min(1, longest / (length || 1));
      path(x, y, u, v, factor * du, factor * dv);
    }
    return { type: "scatter", mode: "lines", x, y, line: { color: colour, width: 1.4 }, hoverinfo: "skip" };
  }

  function dots(points, colour, symbol, size, name) {
    return {
      type: "scatter",
      mode: "markers",
      x: points.map((row) => row[0]),
      y: points.map((row) => row[1]),
      customdata: points.map((row) => [row[2], row[3]]),
      marker: { color: colour, symbol, size },
      hovertemplate: `${name}(%{x:.1f}, %{y:.1f}) px<br>misses by (%{customdata[0]:.3f}, %{customdata[1]:.3f}) px<extra></extra>`,
    };
  }

  function key(view, width, height) {
    const [x, y] = [[], []];
    const length = view.enlargement * view.reference;
    path(x, y, 0.01 * width, -0.05 * height, length, 0);
    const line = { type: "scatter", mode: "lines", x, y, line: { color: "--ink", width: 1.6 }, hoverinfo: "skip" };
    const text = [`${view.referenceLabel} (arrows × ${view.enlargement.toLocaleString("en")})`];
    const place = { x: [0.01 * width + length + 0.015 * width], y: [-0.05 * height] };
    return [line, { type: "scatter", mode: "text", ...place, text, textposition: "middle right", hoverinfo: "skip" }];
  }

  function traces(spec, number) {
    const view = spec.views[number];
    const [used, rejected] = [rows(view.used), rows(view.rejected)];
    return [
      lines(used, view.enlargement, Infinity, "--accent"),
      dots(used, "--accent", "circle", 3.5, ""),
      lines(rejected, view.enlargement, MOST * spec.width, "--bad"),
      dots(rejected, "--bad", "x-thin-open", 8, "left out: "),
      ...key(view, spec.width, spec.height),
    ];
  }

  return { traces };
})();
