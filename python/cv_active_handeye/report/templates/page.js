// SPDX-FileCopyrightText: 2026 active_handeye contributors
// SPDX-License-Identifier: Apache-2.0
"use strict";

(() => {
  const CONFIG = { displayModeBar: false, displaylogo: false, responsive: false, scrollZoom: false, doubleClick: "reset" };
  const figures = JSON.parse(document.getElementById("figures").textContent);
  const plots = [...document.querySelectorAll("[data-figure]")];
  const choice = document.getElementById("view-choice");

  // Names of custom properties become the colours they stand for in the scheme that is on.
  function coloured(value, style) {
    if (typeof value === "string") return value.startsWith("--") ? style.getPropertyValue(value).trim() : value;
    if (Array.isArray(value)) return value.map((item) => coloured(item, style));
    if (value === null || typeof value !== "object") return value;
    return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, coloured(item, style)]));
  }

  function traces(name) {
    const chosen = Number(choice.value);
    if (name === "residuals") return arrows.traces(figures.residuals, chosen);
    if (name === "view_rms" && chosen > 0) return [{ ...figures[name].data[0], selectedpoints: [chosen - 1] }];
    return figures[name].data;
  }

  function webgl() {
    const canvas = document.createElement("canvas");
    return Boolean(canvas.getContext("webgl2") || canvas.getContext("webgl"));
  }

  // The 3-D figure as a view from above and one from the side, for browsers without WebGL.
  function flattened(spec) {
    const flat = (trace, axes, vertical) => ({
      ...trace, ...axes, type: "scatter", y: trace[vertical], z: undefined, hovertemplate: undefined,
      hoverinfo: "none", line: { ...trace.line, width: 1.2 },
    });
    const data = spec.data.flatMap((trace) => [
      flat(trace, { xaxis: "x", yaxis: "y" }, "y"),
      flat(trace, { xaxis: "x2", yaxis: "y2" }, "z"),
    ]);
    const { scene, ...layout } = spec.layout;
    const axis = (source, more) => ({ ...scene[source], zeroline: false, nticks: 6, automargin: true, ...more });
    return {
      data,
      layout: {
        ...layout,
        xaxis: axis("xaxis", { domain: [0, 0.44] }),
        yaxis: axis("yaxis", { scaleanchor: "x" }),
        xaxis2: axis("xaxis", { domain: [0.58, 1], anchor: "y2" }),
        yaxis2: axis("zaxis", { scaleanchor: "x2", anchor: "x2" }),
      },
    };
  }

  async function draw(plot) {
    const name = plot.dataset.figure;
    const style = getComputedStyle(document.documentElement);
    const size = { width: plot.clientWidth, height: plot.clientHeight };
    const layout = { ...figures[name].layout, ...size, uirevision: "kept" };
    if (layout.scene) {
      const { camera } = layout.scene;
      layout.scene = { ...layout.scene, camera: { ...camera, eye: eye(Object.values(camera.eye), plot) } };
    }
    await Plotly.react(plot, coloured(traces(name), style), coloured(layout, style), CONFIG);
    plot.setAttribute("aria-busy", "false");
  }

  function redraw() {
    return Promise.all(plots.map(draw));
  }

  // Figures follow the size of their boxes, and so that of the window.
  function prepareSizes() {
    const fits = (plot) => plot.clientWidth === plot._fullLayout.width && plot.clientHeight === plot._fullLayout.height;
    const observer = new ResizeObserver((entries) => requestAnimationFrame(() => {
      for (const { target } of entries) if (!fits(target)) draw(target);
    }));
    for (const plot of plots) observer.observe(plot);
  }

  function choose(number) {
    choice.value = String(number);
    document.getElementById("view-words").textContent = figures.residuals.views[number].words;
    for (const plot of plots) if (["residuals", "view_rms"].includes(plot.dataset.figure)) draw(plot);
  }

  function prepareChoice() {
    figures.residuals.views.forEach((view, number) => choice.add(new Option(view.label, String(number))));
    choice.addEventListener("change", () => choose(Number(choice.value)));
    for (const button of document.querySelectorAll("[data-step]")) {
      button.addEventListener("click", () => {
        const count = choice.options.length;
        choose((Number(choice.value) + Number(button.dataset.step) + count) % count);
      });
    }
    document.getElementById("view-words").textContent = figures.residuals.views[0].words;
    document.getElementById("view-control").hidden = false;
  }

  // The camera of the 3-D figure steps back where the figure is narrower than it is high.
  function eye([x, y, z], plot) {
    const back = Math.max(1, (1.05 * plot.clientHeight) / plot.clientWidth);
    return { x: back * x, y: back * y, z: back * z };
  }

  function prepareEyes(plot) {
    for (const button of document.querySelectorAll("[data-eye]")) {
      const place = button.dataset.eye.split(",").map(Number);
      const up = place[0] === 0 && place[1] === 0 ? { x: 0, y: 1, z: 0 } : { x: 0, y: 0, z: 1 };
      button.addEventListener("click", () => {
        const camera = { eye: eye(place, plot), up, center: { x: 0, y: 0, z: -0.08 } };
        Plotly.relayout(plot, { "scene.camera": camera });
      });
    }
    document.getElementById("eye-control").hidden = false;
  }

  async function copy(button) {
    const text = document.getElementById(button.dataset.copy).textContent;
    const area = document.body.appendChild(document.createElement("textarea"));
    area.value = text;
    area.select();
    const done = document.execCommand("copy") || (await navigator.clipboard.writeText(text).then(() => true, () => false));
    area.remove();
    button.focus();
    document.getElementById("announcement").textContent = done ? "Copied" : "Copying is not allowed here";
    const label = button.textContent;
    button.textContent = done ? "Copied" : "Not allowed";
    setTimeout(() => { button.textContent = label; }, 1500);
  }

  function prepareSchemes() {
    const printing = document.documentElement.classList;
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => redraw());
    addEventListener("beforeprint", () => { printing.add("printing"); redraw(); });
    addEventListener("afterprint", () => { printing.remove("printing"); redraw(); });
  }

  async function start() {
    prepareChoice();
    for (const button of document.querySelectorAll("[data-copy]")) button.addEventListener("click", () => copy(button));
    if (!webgl()) figures.motion = flattened(figures.motion);
    for (const plot of plots) {
      await new Promise((resolve) => setTimeout(resolve));
      await draw(plot);
      if (plot.dataset.figure === "motion" && figures.motion.layout.scene) prepareEyes(plot);
      if (plot.dataset.figure === "view_rms") plot.on("plotly_click", (event) => choose(event.points[0].pointNumber + 1));
    }
    prepareSizes();
    prepareSchemes();
  }

  start();
})();
