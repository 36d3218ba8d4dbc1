// Error over time of all integrators, with a band for each (uPlot).

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { element, numberText, segmented, superscript } from "./controls.js";

export const kMetrics = [
  ["rel_mse", "relMSE"],
  ["trimmed_rel_mse", "trimmed"],
  ["mse", "MSE"],
  ["smape", "sMAPE"],
  ["bias", "bias"],
];
const kHeight = 380;

const styleOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function axisText(value) {
  const exponent = Math.log10(Math.abs(value));
  if (value === 0 || (exponent > -3.5 && exponent < 4.5)) return String(Number(value.toPrecision(3)));
  const whole = Math.floor(exponent + 1e-9);
  const mantissa = Number((value / 10 ** whole).toPrecision(2));
  return `${mantissa === 1 ? "" : `${mantissa}\u00b7`}10${superscript(whole)}`;
}

// Which lines of a logarithmic axis are drawn and named: powers of ten, more where few of them are seen.
function isMajor(value, scale) {
  const decades = Math.log10(scale.max / scale.min);
  const wanted = decades > 2.5 ? [1] : decades > 1.2 ? [1, 3] : [1, 2, 3, 5, 7];
  const mantissa = value / 10 ** Math.floor(Math.log10(value) + 1e-9);
  return wanted.some((w) => Math.abs(mantissa - w) < 1e-6);
}

// The lines of an axis that are kept, null for the others.
function logFilter(name) {
  return (plot, splits) => splits.map((v) => (isMajor(v, plot.scales[name]) ? v : null));
}

// All of the curves, and of their bands what lies within this factor of them: a band of three seeds may span decades.
const kBandShown = 6;
function verticalRange(data, logarithmic) {
  const curves = data.slice(1).filter((_, i) => i % 3 === 0).flat().filter((v) => v !== null && v !== undefined);
  const least = Math.min(...curves);
  const most = Math.max(...curves);
  if (!logarithmic) {
    const reach = Math.max(Math.abs(least), Math.abs(most), 1e-3) * 1.6;
    return [-reach, reach];
  }
  const all = data.slice(1).flat().filter((v) => v > 0);
  return [Math.max(Math.min(...all), least / kBandShown) / 1.2, Math.min(Math.max(...all), most * kBandShown) * 1.2];
}

export class Chart {
  // `entrants`: those with a summary; `colors`: name of the style variable of each label.
  constructor(study, entrants, colors) {
    this.study = study;
    this.entrants = entrants;
    this.colors = colors;
    this.metric = "rel_mse";
    this.abscissa = study.plan.limit === "passes" ? "passes" : "seconds";
    this.hidden = new Set();
    this.holder = document.getElementById("chart");
    segmented(document.getElementById("metric"), kMetrics, this.metric, (metric) => {
      this.metric = metric;
      this.draw();
    });
    const axes = [
      ["seconds", "time"],
      ["passes", "passes"],
    ];
    segmented(document.getElementById("abscissa"), axes, this.abscissa, (abscissa) => {
      this.abscissa = abscissa;
      this.draw();
    });
    this.#makeLegend();
    new ResizeObserver(() => this.#resize()).observe(this.holder);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    this.draw();
  }

  #makeLegend() {
    const chips = this.entrants.map((entrant) => {
      const chip = element("button", { type: "button", "aria-pressed": "true", title: "Show or hide" },
        element("i", { style: `background: var(${this.colors.get(entrant.label)})` }), entrant.label,
        element("span", { class: "value" }));
      chip.addEventListener("click", () => {
        if (!this.hidden.delete(entrant.label)) this.hidden.add(entrant.label);
        chip.setAttribute("aria-pressed", String(!this.hidden.has(entrant.label)));
        this.draw();
      });
      return chip;
    });
    this.values = chips.map((chip) => chip.querySelector(".value"));
    document.getElementById("legend").replaceChildren(...chips);
  }

  #resize() {
    if (this.plot && this.plot.width !== this.holder.clientWidth)
      this.plot.setSize({ width: this.holder.clientWidth, height: kHeight });
  }

  // Columns of one entrant: x, mean, low, high. Intervals that cannot be drawn on the scale are left out.
  #tableOf(entrant) {
    const factor = this.metric === "bias" ? 100 : 1;
    const drawable = (v) => (v === null || (this.metric !== "bias" && !(v > 0)) ? null : v * factor);
    const points = entrant.summary.curve;
    const column = (key) => points.map((p) => drawable(p[this.metric][key]));
    return [points.map((p) => p[this.abscissa]), column("mean"), column("low"), column("high")];
  }

  #noiseTable(tables) {
    const noise = this.study.reference.noise?.[this.metric];
    if (!(noise > 0) || this.metric === "bias") return [];
    const xs = tables.flatMap((t) => t[0]);
    return [[[Math.min(...xs), Math.max(...xs)], [noise, noise]]];
  }

  draw() {
    this.plot?.destroy();
    this.plot = null;
    const shown = this.entrants.filter((e) => !this.hidden.has(e.label));
    document.getElementById("chart-caption").replaceChildren(...this.#caption());
    this.values.forEach((v) => (v.textContent = ""));
    if (shown.length === 0) return;
    const tables = shown.map((e) => this.#tableOf(e));
    const noise = this.#noiseTable(tables);
    const data = uPlot.join([...tables, ...noise]);
    this.plot = new uPlot(this.#options(shown, data, noise.length > 0), data, this.holder);
  }

  #options(shown, data, withNoise) {
    const series = [{}];
    const bands = [];
    for (const entrant of shown) {
      const color = styleOf(this.colors.get(entrant.label));
      const first = series.length;
      const invisible = { width: 0, points: { show: false }, spanGaps: true, stroke: "transparent" };
      series.push(
        { stroke: color, width: 2, spanGaps: true, points: { show: true, size: 5, fill: color, width: 0 } },
        { ...invisible },
        { ...invisible },
      );
      bands.push({ series: [first + 2, first + 1], fill: `${color}2e` });
    }
    const text = styleOf("--muted");
    const grid = { stroke: styleOf("--grid"), width: 1 };
    if (withNoise) series.push({ stroke: text, width: 1, dash: [5, 5], spanGaps: true, points: { show: false } });
    const bias = this.metric === "bias";
    const font = "12px system-ui, sans-serif";
    const axis = { stroke: text, grid, ticks: grid, font, labelFont: font, labelSize: 20, size: 34 };
    const logarithmic = (name) => {
      const lines = { ...grid, filter: logFilter(name) };
      const values = (plot, splits) => splits.map((v) => (v === null ? "" : axisText(v)));
      return { grid: lines, ticks: lines, filter: logFilter(name), values };
    };
    return {
      width: this.holder.clientWidth,
      height: kHeight,
      legend: { show: false },
      cursor: { points: { size: 7 }, drag: { x: false, y: false } },
      scales: {
        x: { time: false, distr: 3, range: (plot, least, most) => [least / 1.15, most * 1.15] },
        y: { distr: bias ? 1 : 3, range: () => verticalRange(data, !bias) },
      },
      axes: [
        { ...axis, ...logarithmic("x"), label: this.abscissa === "seconds" ? "seconds of rendering" : "passes" },
        { ...axis, size: 64, ...(bias ? {} : logarithmic("y")), label: this.#axisName() },
      ],
      series,
      bands,
      hooks: { setCursor: [(plot) => this.#showValues(plot, shown)] },
    };
  }

  #axisName() {
    return this.metric === "bias" ? "bias of the mean, %" : Object.fromEntries(kMetrics)[this.metric];
  }

  // The value of each curve at the pointer, in the legend.
  #showValues(plot, shown) {
    const index = plot.cursor.idx;
    this.entrants.forEach((entrant, i) => {
      const column = shown.indexOf(entrant);
      const value = index === null || index === undefined || column < 0 ? null : plot.data[1 + 3 * column][index];
      this.values[i].textContent = value === null || value === undefined ? "" : numberText(value);
    });
  }

  #caption() {
    const seeds = this.study.plan.seeds.length;
    const mean = this.metric === "bias" ? "mean" : "geometric mean";
    const text =
      seeds > 1
        ? `Lines: ${mean} over ${seeds} seeds. Bands: ${100 * this.study.plan.confidence} % confidence interval of that mean (Student's t). `
        : "One seed: no confidence bands. ";
    const noise = this.study.reference.noise?.[this.metric] > 0 && this.metric !== "bias";
    return [text, noise ? "Dashed: noise of the reference itself." : ""];
  }
}
