// The results at the end, the best of each metric marked.

import { element, numberText, percentText } from "./controls.js";

const kErrors = [
  ["rel_mse", "relMSE"],
  ["trimmed_rel_mse", "trimmed relMSE"],
  ["mse", "MSE"],
  ["smape", "sMAPE"],
];

const isTied = (winner, label) => winner?.tied.includes(label) ?? false;

function markedCell(winner, label, text, small, title) {
  const best = winner?.entrant === label;
  const kind = best ? "best" : isTied(winner, label) ? "tied" : undefined;
  return element("td", { class: kind, title, "data-best": best }, element("span", {}, text),
    element("small", {}, small));
}

function intervalText(interval, format) {
  if (interval.low === null) return undefined;
  return `95 % interval: ${format(interval.low)} \u2026 ${format(interval.high)}`;
}

function errorCell(study, entrant, metric) {
  const winner = study.winners[metric];
  const interval = entrant.summary.final[metric];
  const best = study.entrants.find((e) => e.label === winner?.entrant)?.summary.final[metric].mean;
  const ratio = interval.mean / best;
  const small = winner?.entrant === entrant.label ? "best" : best > 0 ? `\u00d7${Number(ratio.toPrecision(3))}` : "";
  return markedCell(winner, entrant.label, numberText(interval.mean), small, intervalText(interval, numberText));
}

// Judged by its size in each run; the signed mean below tells a bias from noise.
function biasCell(study, entrant) {
  const { final_absolute_bias: size, final } = entrant.summary;
  const reach = final.bias.high === null ? "" : ` \u00b1 ${(100 * (final.bias.high - final.bias.mean)).toFixed(2)}`;
  return markedCell(study.winners.bias, entrant.label, `${(100 * size.mean).toFixed(2)} %`,
    `${percentText(final.bias.mean).replace(" %", "")}${reach}`, intervalText(final.bias, percentText));
}

function rateCell(entrant) {
  const rate = entrant.summary.rates.rel_mse;
  if (!rate) return element("td", {}, "\u2013");
  const error = rate.standard_error === null ? "" : `\u00b1 ${rate.standard_error.toFixed(2)}`;
  const text = rate.slope.toFixed(2).replace("-", "\u2212");
  return element("td", {}, element("span", {}, text), element("small", {}, error));
}

function row(study, entrant, colors) {
  const head = element("th", { scope: "row" },
    element("i", { style: `background: var(${colors.get(entrant.label)})` }), entrant.label);
  if (!entrant.summary) {
    const reason = entrant.refusal ?? "interrupted before a run was complete";
    return element("tr", {}, head, element("td", { colspan: "8", class: "reason" }, reason));
  }
  const { seconds, passes, runs, final } = entrant.summary;
  const wanted = study.plan.seeds.length;
  const note = runs < wanted ? `${runs} of ${wanted} seeds` : "";
  return element("tr", {}, head, ...kErrors.map(([metric]) => errorCell(study, entrant, metric)),
    biasCell(study, entrant), element("td", {}, numberText(final.rel_mse.mean * seconds)), rateCell(entrant),
    element("td", {}, element("span", {}, String(Math.round(passes))),
      element("small", {}, note || `${Number(seconds.toPrecision(3))} s`)));
}

export function fillTable(study, colors) {
  const titles = ["integrator", ...kErrors.map(([, title]) => title), "|bias|", "relMSE \u00d7 s", "rate", "passes"];
  const head = element("thead", {}, element("tr", {}, ...titles.map((t) => element("th", { scope: "col" }, t))));
  const body = element("tbody", {}, ...study.entrants.map((e) => row(study, e, colors)));
  document.getElementById("table").replaceChildren(head, body);
  const tests =
    study.plan.seeds.length > 1
      ? "\u2248: Welch's test over the seeds does not tell it from the best (p > 0.05). "
      : "One seed: nothing says which differences are noise. ";
  document.getElementById("table-caption").textContent =
    `Geometric means of errors over the seeds; mean size of the bias, below it the signed mean with its 95 % interval. ${tests}` +
    "Rate: slope of log relMSE over log time with its standard error; \u22121 is Monte Carlo\u2019s.";
}
