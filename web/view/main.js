// The page of `metrolux view` and `render --serve`.
import { heatColor } from "./color.js";
import { drawChart } from "./chart.js";
import { imageOf } from "./display.js";
import { Hands } from "./hands.js";
import { shortestText } from "./pixels.js";
import { about, command, follow, frame, pixel } from "./server.js";
import { Stage } from "./stage.js";

const byId = (id) => document.getElementById(id);
const kPhases = {
  loading: "loading the scene",
  rendering: "rendering",
  paused: "paused",
  stopped: "stopped",
  done: "done",
  ended: "the program has ended; this is its last picture",
  lost: "no connection to the program",
};

const stage = new Stage(byId("stage"));
const hands = new Hands(stage, byId("selection"), tellProblem);
const frames = [];
const display = { layer: "color", exposure: 0, curve: "srgb" };
let info = null;
let state = null;
let told = 0;

function tell(text, isError = false) {
  const element = byId("message");
  element.textContent = text.trim();
  element.toggleAttribute("data-error", isError);
  element.hidden = false;
  clearTimeout(tell.timer);
  tell.timer = setTimeout(() => (element.hidden = true), isError ? 12000 : 5000);
}
function tellProblem(problem) {
  tell(problem.message || String(problem), true);
}
const send = (name, values) => command(name, values).catch(tellProblem);

// Frames: one is on its way for each side at most, so that a slow page is behind by one and never by more.
const underway = [];
const wanted = (side) => {
  const news = state.sides[side]?.frame;
  const shown = frames[side];
  if (!news) return false;
  if (!shown || shown.layer !== display.layer || shown.generation !== news.generation) return true;
  return (display.layer === "color" || display.layer === "error" || display.layer === "variance") && shown.version !== news.version;
};
async function fetchFrame(side) {
  if (underway[side] || !wanted(side)) return;
  underway[side] = true;
  try {
    const news = await frame(side, display.layer);
    if (side < state.sides.length && news.layer === display.layer) {
      frames[side] = news;
      paint(side);
    }
  } catch (problem) {
    if (problem.status === 503 || problem.status === 204) await new Promise((resolve) => setTimeout(resolve, 300));
  }
  underway[side] = false;
  if (state.phase !== "lost") fetchFrame(side);
}
function paint(side) {
  const shown = frames[side];
  if (!shown) return;
  byId("empty").hidden = true;
  stage.show(side, imageOf(shown, display.exposure, display.curve), shown.scale > 1);
  document.documentElement.dataset.pictures = Number(document.documentElement.dataset.pictures ?? 0) + 1;
  readout();
}

const duration = (seconds) => {
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  const minutes = Math.floor(whole / 60) % 60;
  return whole < 3600
    ? `${minutes} min ${whole % 60} s`
    : `${Math.floor(whole / 3600)} h ${minutes} min`;
};
const errorText = (error) => (error === null ? "after eight passes" : `${(100 * error).toPrecision(3)} %`);

function row(list, name, value) {
  const term = document.createElement("dt");
  const text = document.createElement("dd");
  term.textContent = name;
  text.textContent = value;
  text.dataset.name = name;
  list.append(term, text);
}
function showSides() {
  const blocks = state.sides.map((side) => {
    const block = document.createElement("div");
    block.className = "side";
    const title = document.createElement("h3");
    title.textContent = side.integrator;
    const list = document.createElement("dl");
    row(list, "passes", String(side.passes));
    row(list, "time", duration(side.seconds));
    if (side.seconds_remaining >= 0 && side.seconds_remaining < 1e8 && state.phase === "rendering")
      row(list, "remaining", duration(side.seconds_remaining));
    row(list, "estimated error", errorText(side.relative_error));
    row(list, "rays", `${(side.rays_per_second / 1e6).toFixed(2)} M/s`);
    block.append(title, list);
    if (side.note) block.append(Object.assign(document.createElement("p"), { className: "hint", textContent: side.note }));
    return block;
  });
  byId("sides").replaceChildren(...blocks);
  drawChart(byId("chart"), state.sides.map((side) => side.curve));
}
function showLabels() {
  const width = stage.paneWidth();
  const labels = state.sides.map((side, i) => {
    const label = document.createElement("span");
    label.style.left = `${i * width + 12}px`;
    label.textContent = side.integrator;
    const preview = frames[i]?.scale > 1;
    if (preview) label.append(Object.assign(document.createElement("small"), { textContent: `  preview 1/${frames[i].scale}` }));
    return label;
  });
  byId("labels").replaceChildren(...labels);
}

// What was asked for and comes after the pass in progress.
let coming = "";
function showPhase(phase, reason) {
  document.body.dataset.phase = phase;
  if (phase !== "rendering") coming = "";
  byId("phase-text").textContent = kPhases[phase] + (reason ? `: ${reason}` : "") + coming;
  const gone = phase === "ended" || phase === "lost";
  const resting = phase === "paused" || phase === "stopped";
  byId("pause").textContent = resting ? "Go on" : "Pause";
  byId("pause").disabled = gone || phase === "loading" || phase === "done" || (phase === "stopped" && !info?.explores);
  byId("stop").disabled = gone || phase === "loading" || phase === "done" || phase === "stopped";
  byId("save").disabled = gone || phase === "loading";
  for (const control of byId("explore").querySelectorAll("button, select")) control.disabled = gone;
}

function changed(next) {
  state = next;
  if (state.message.number > told) {
    if (told > 0 || state.message.error || state.phase !== "ended") tell(state.message.text, state.message.error);
    told = state.message.number;
    coming = "";
  }
  showPhase(state.phase, state.reason);
  if (state.sides.length === 0) return;
  frames.length = Math.min(frames.length, state.sides.length);
  hands.image = state.resolution;
  stage.arrange(state.sides.length, state.window);
  const whole = state.window[2] === state.resolution[0] && state.window[3] === state.resolution[1];
  byId("full").disabled = whole || state.phase === "ended";
  byId("integrator").value = state.sides[0].integrator;
  byId("compare").value = state.sides[1]?.integrator ?? "";
  byId("share").hidden = state.sides.length < 2;
  const error = state.sides[0].relative_error;
  document.title = `${error === null ? "" : `${(100 * error).toPrecision(2)} % `}${info.scene} \u00b7 Metrolux`;
  showSides();
  showLabels();
  state.sides.forEach((_, side) => fetchFrame(side));
}

// Values below the pointer: those of the program, which has more digits than are sent.
let pointer = null;
let asked = 0;
async function readout() {
  const output = byId("readout");
  if (!pointer || !state?.sides.length) return void (output.textContent = "");
  const place = stage.placeAt(pointer[0], pointer[1]);
  const shown = frames[place.side];
  const [wx, wy, ww, wh] = state.window;
  const x = Math.floor(place.x);
  const y = Math.floor(place.y);
  if (!shown || x < wx || y < wy || x >= wx + ww || y >= wy + wh) return void (output.textContent = "");
  const number = ++asked;
  const inside = (value, most, size) => Math.min(Math.floor((value * size) / most), size - 1);
  try {
    const { values, passes } = await pixel(place.side, display.layer, inside(x - wx, ww, shown.width), inside(y - wy, wh, shown.height), shown.width, shown.height);
    if (number !== asked || !pointer) return;
    const names = values.length === 3 ? ["R", "G", "B"] : [display.layer];
    output.textContent = [`x ${x}  y ${y}`, ...names.map((name, i) => `${name}  ${typeof values[i] === "number" ? shortestText(values[i]) : values[i]}`)].join("\n");
    Object.assign(output.dataset, { x, y, passes, values: JSON.stringify(values) });
  } catch {
    if (number === asked) output.textContent = `x ${x}  y ${y}`;
  }
}
byId("stage").addEventListener("pointermove", (event) => {
  pointer = event.target.closest(".tools") ? null : hands.at(event);
  readout();
});
byId("stage").addEventListener("pointerleave", () => {
  pointer = null;
  readout();
});

// Settings of the display.
function repaint() {
  byId("exposure-value").textContent = (display.exposure > 0 ? "+" : "") + display.exposure.toFixed(1);
  byId("scale").hidden = display.layer !== "error";
  frames.forEach((_, side) => paint(side));
}
function setExposure(value) {
  display.exposure = Math.min(Math.max(Math.round(value * 10) / 10, -10), 10);
  byId("exposure").value = display.exposure;
  repaint();
}
function setLayer(layer) {
  display.layer = layer;
  byId("layer").value = layer;
  byId("scale").hidden = layer !== "error";
  state?.sides.forEach((_, side) => fetchFrame(side));
}
byId("exposure").addEventListener("input", (event) => setExposure(Number(event.target.value)));
byId("exposure").addEventListener("dblclick", () => setExposure(0));
byId("curve").addEventListener("change", (event) => {
  display.curve = event.target.value;
  repaint();
});
byId("layer").addEventListener("change", (event) => setLayer(event.target.value));
stage.changed = () => {
  byId("zoom-value").textContent = `${Number((100 * stage.view.zoom * (window.devicePixelRatio || 1)).toPrecision(3))} %`;
  if (state?.sides.length) showLabels();
};

// Commands.
function sendForLater(name, text) {
  coming = `, ${text} after this pass`;
  showPhase(state.phase, state.reason);
  send(name);
}
const togglePause = () => (state?.phase === "rendering" ? sendForLater("pause", "pausing") : send("resume"));
const save = () => (state?.phase === "rendering" ? sendForLater("save", "saving") : send("save"));
byId("pause").addEventListener("click", togglePause);
byId("stop").addEventListener("click", () => (state?.phase === "rendering" ? sendForLater("stop", "stopping") : send("stop")));
byId("save").addEventListener("click", save);
byId("fit").addEventListener("click", () => stage.fit());
byId("actual").addEventListener("click", () => stage.actual());
byId("integrator").addEventListener("change", (event) => send("integrator", { integrator: event.target.value }));
byId("compare").addEventListener("change", (event) => send("compare", { integrator: event.target.value }));
byId("reset-camera").addEventListener("click", () => send("reset_camera"));
byId("full").addEventListener("click", () => send("crop"));
byId("copy-camera").addEventListener("click", async () => {
  const text = `<transform name="to_world"><matrix value="${state.camera.join(" ")}"/></transform>`;
  try {
    await navigator.clipboard.writeText(text);
    tell("The camera is in the clipboard, for the <sensor> of a scene file.");
  } catch {
    tell(text);
  }
});

const handButtons = [...document.querySelectorAll("[data-hand]")].filter((element) => element.tagName === "BUTTON");
function chooseHand(hand) {
  hands.choose(hand);
  for (const button of handButtons) {
    const chosen = button.dataset.hand === hand;
    button.setAttribute("aria-checked", chosen);
    button.tabIndex = chosen ? 0 : -1;
  }
}
for (const button of handButtons) {
  button.addEventListener("click", () => chooseHand(button.dataset.hand));
  button.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const next = handButtons[(handButtons.indexOf(button) + step + handButtons.length) % handButtons.length];
    chooseHand(next.dataset.hand);
    next.focus();
    event.stopPropagation();
  });
}

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("select, input")) return;
  const explores = info?.explores;
  const keys = {
    " ": () => !byId("pause").disabled && togglePause(),
    s: () => !byId("save").disabled && save(),
    f: () => stage.fit(),
    a: () => stage.actual(),
    e: () => setLayer(display.layer === "error" ? "color" : "error"),
    r: () => explores && send("reset_camera"),
    1: () => chooseHand("look"),
    2: () => explores && chooseHand("camera"),
    3: () => explores && chooseHand("crop"),
    "[": () => setExposure(display.exposure - 0.5),
    "]": () => setExposure(display.exposure + 0.5),
    Escape: () => hands.cancel(),
  };
  if (event.key === " " && event.target.closest("button")) return;
  const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (act) act();
  else if (!hands.key(event.key)) return;
  event.preventDefault();
});

function drawScale() {
  const context = byId("scale-canvas").getContext("2d");
  for (let i = 0; i < 256; ++i) {
    context.fillStyle = `rgb(${heatColor(i / 255).join()})`;
    context.fillRect(i, 0, 1, 1);
  }
}

const option = (value, text, title = "") => Object.assign(document.createElement("option"), { value, textContent: text, title });

async function start() {
  info = await about();
  document.title = `${info.scene} \u00b7 Metrolux`;
  byId("title").textContent = info.scene;
  byId("title").title = info.program;
  byId("save").title = `Write ${info.outputs.join(", ")} and a checkpoint (S)`;
  byId("explore").hidden = !info.explores;
  for (const button of handButtons) button.hidden = !info.explores;
  const layers = { color: "image", error: "estimated error", variance: "variance" };
  for (const [value, text] of Object.entries(layers)) byId("layer").append(option(value, text));
  for (const layer of info.layers) byId("layer").append(option(layer, layer));
  byId("compare").append(option("", "nothing"));
  for (const { name, summary } of info.integrators) {
    byId("integrator").append(option(name, name, summary));
    byId("compare").append(option(name, name, summary));
  }
  drawScale();
  chooseHand("look");
  await follow(changed, () => {
    if (state) state.phase = "lost";
    showPhase("lost");
  });
}
start().catch((problem) => {
  showPhase("lost");
  tellProblem(problem);
});
