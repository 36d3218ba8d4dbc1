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

// Labels of a logarithmic axis: powers of ten, with 2 and 5 when there are few.
function logLabels(plot, splits) {
  const decades = Math.log10(splits[splits.length - 1] / splits[0]);
  const wanted = decades > 2.5 ? [1] : decades > 1.2 ? [1, 3] : [1, 2, 3, 5, 7];
  return splits.map((v) => {
    const mantissa = Math.round(v / 10 ** Math.floor(Math.log10(v) + 1e-9));
    return wanted.includes(mantissa) ? axisText(v) : "";
  });
}

export class Chart {
  // `entrants`: those with a summary; `colours`: name of the style variable of each label.
  constructor(study, entrants, colours) {
    this.study = study;
    this.entrants = entrants;
    this.colours = colours;
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
        element("i", { style: `background: var(${this.colours.get(entrant.label)})` }), entrant.label,
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
    this.plot = new uPlot(this.#options(shown, noise.length > 0), data, this.holder);
  }

  #options(shown, withNoise) {
    const series = [{}];
    const bands = [];
    for (const entrant of shown) {
      const colour = styleOf(this.colours.get(entrant.label));
      const first = series.length;
      const invisible = { width: 0, points: { show: false }, spanGaps: true, stroke: "transparent" };
      series.push(
        { stroke: colour, width: 2, spanGaps: true, points: { show: true, size: 5, fill: colour, width: 0 } },
        { ...invisible },
        { ...invisible },
      );
      bands.push({ series: [first + 2, first + 1], fill: `${colour}2e` });
    }
    const text = styleOf("--muted");
    const grid = { stroke: styleOf("--grid"), width: 1 };
    if (withNoise) series.push({ stroke: text, width: 1, dash: [5, 5], spanGaps: true, points: { show: false } });
    const bias = this.metric === "bias";
    const font = "12px system-ui, sans-serif";
    const axis = { stroke: text, grid, ticks: grid, font, labelFont: font, labelSize: 22 };
    return {
      width: this.holder.clientWidth,
      height: kHeight,
      legend: { show: false },
      cursor: { points: { size: 7 }, drag: { x: false, y: false } },
      scales: { x: { time: false, distr: 3 }, y: bias ? {} : { distr: 3 } },
      axes: [
        { ...axis, values: logLabels, label: this.abscissa === "seconds" ? "seconds of rendering" : "passes" },
        { ...axis, size: 64, ...(bias ? {} : { values: logLabels }), label: this.#axisName() },
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
