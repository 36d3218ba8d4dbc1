import "./style.css";
import { Chart } from "./chart.js";
import { durationText, element, percentText } from "./controls.js";
import { decodeImage, halfText, shortestText } from "./pixels.js";
import { fillTable } from "./table.js";
import { Viewer } from "./viewer.js";

const kColors = 10;

const content = (id) => JSON.parse(document.getElementById(id).textContent);

function limitText(plan) {
  return plan.limit === "seconds" ? durationText(plan.seconds) + (plan.clock === "cpu" ? " of processor time" : "") : `${plan.passes} passes`;
}

function fillHeader(study) {
  const { scene, plan, machine } = study;
  document.title = `${scene.name} \u2013 Metrolux study`;
  document.getElementById("title").textContent = scene.name;
  const seeds = plan.seeds.length;
  document.getElementById("subtitle").textContent = [
    `${study.entrants.length} integrators, ${limitText(plan)} each, ${seeds} seed${seeds === 1 ? "" : "s"}`,
    `${scene.window.width} \u00d7 ${scene.window.height} pixels`,
    `${machine.threads} thread${machine.threads === 1 ? "" : "s"}`,
    study.written.slice(0, 10),
  ].join(" \u00b7 ");
}

function referenceText(study, precision) {
  const { reference } = study;
  const pixels = precision === "half" ? "pixels here: half precision, the EXR files have single" : "";
  if (reference.source === "file") return [reference.file, pixels].filter(Boolean).join("; ");
  const how = `rendered by ${reference.integrator} in ${durationText(reference.seconds)}, two halves with their own seeds`;
  return [how, `relMSE of its noise ${reference.noise.rel_mse.toPrecision(3)}`, pixels].filter(Boolean).join("; ");
}

// What a reader must know before believing a number.
function notesOf(study) {
  const notes = [];
  if (study.interrupted) notes.push("The study was interrupted: runs that were cut short are left out of curves and table.");
  const noise = study.reference.noise?.rel_mse;
  const close = study.entrants.filter((e) => e.summary && noise > 0.2 * e.summary.final.rel_mse.mean);
  if (close.length > 0)
    notes.push(
      `The reference\u2019s own noise is more than a fifth of the relMSE of ${close.map((e) => e.label).join(", ")}: render a longer one.`,
    );
  if (study.reference.source === "rendered")
    notes.push(
      `The reference comes from ${study.reference.integrator}, so that a bias of its own would be charged to the others: check that they agree about the bias.`,
    );
  const whole = study.entrants.filter((e) => e.summary && e.summary.final.bias.low !== null);
  const off = whole.filter((e) => e.summary.final.bias.low > 0 || e.summary.final.bias.high < 0);
  if (whole.length > 1 && off.length === whole.length)
    notes.push(
      `All integrators are off the reference beyond their noise (${off.map((e) => `${e.label} ${percentText(e.summary.final.bias.mean)}`).join(", ")}): suspect the reference.`,
    );
  return notes;
}

function fillProvenance(study, precision) {
  const { machine, scene } = study;
  const options = Object.entries(scene.options ?? {}).map(([k, v]) => `${k} ${typeof v === "string" ? v : JSON.stringify(v)}`);
  const entries = [
    ["Scene", [scene.file, ...options].join(", ")],
    ["Reference", referenceText(study, precision)],
    ["Machine", `${machine.processor}, ${machine.threads} of ${machine.cores} cores, ${machine.system}`],
    ["Program", `Metrolux ${study.version}, compiled by ${machine.compiler}, ${study.written}`],
    ["relMSE", `mean over pixels and channels of (a\u2212b)\u00b2 / (b\u00b2 + ${study.plan.epsilon}); trimmed: without the 0.1 % worst pixels`],
    ["Command", element("code", {}, study.command.join(" "))],
  ];
  document
    .getElementById("provenance")
    .replaceChildren(...entries.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]));
}

async function start() {
  const study = content("study");
  const { images, precision } = content("pixels");
  const colors = new Map(study.entrants.map((e, i) => [e.label, `--series-${i % kColors}`]));
  fillHeader(study);
  document.getElementById("notes").replaceChildren(...notesOf(study).map((note) => element("li", {}, note)));
  fillProvenance(study, precision);
  fillTable(study, colors);
  new Chart(study, study.entrants.filter((e) => e.summary), colors);
  const decoded = await Promise.all(images.map((image) => decodeImage(image, precision)));
  new Viewer(decoded, study.plan.epsilon, precision === "half" ? halfText : shortestText).start();
  document.documentElement.dataset.ready = "true";
}

start().catch((error) => {
  document.getElementById("notes").replaceChildren(element("li", {}, `This page could not be shown: ${error.message}`));
  throw error;
});
