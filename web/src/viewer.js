// The image viewer: two images share one zoom and position, divided by a line that can be dragged.

import { displayPixels, errorPixels, heatColor, relativeError } from "./color.js";
import { element, segmented } from "./controls.js";

const kLargestZoom = 128;

// Canvases with display colors, made when they are first shown and again when exposure or mode change.
class DisplayCache {
  #entries = new Map();
  constructor(reference, epsilon) {
    this.reference = reference;
    this.epsilon = epsilon;
  }
  canvasOf(image, mode, exposure) {
    const key = mode === "error" ? mode : `${mode} ${exposure}`;
    const entry = this.#entries.get(image);
    if (entry?.key === key) return entry.canvas;
    const canvas = entry?.canvas ?? element("canvas", { width: image.width, height: image.height });
    const pixels =
      mode === "error" ? errorPixels(image, this.reference, this.epsilon) : displayPixels(image, exposure);
    canvas.getContext("2d").putImageData(pixels, 0, 0);
    this.#entries.set(image, { key, canvas });
    return canvas;
  }
}

export class Viewer {
  // `images`: the reference first.
  constructor(images, epsilon, textOf) {
    this.images = images;
    this.epsilon = epsilon;
    this.textOf = textOf;
    this.cache = new DisplayCache(images[0], epsilon);
    this.left = Math.min(1, images.length - 1);
    this.right = 0;
    this.mode = "color";
    this.exposure = 0;
    this.wipe = true;
    this.split = 0.5; // share of the stage's width
    this.pointer = null; // pixel below the pointer
    this.stage = document.getElementById("stage");
    this.canvas = document.getElementById("canvas");
    this.#makeControls();
    this.#listen();
    this.#shapeStage();
    new ResizeObserver(() => this.#resize()).observe(this.stage);
  }

  get size() {
    return { width: this.images[0].width, height: this.images[0].height };
  }

  #makeControls() {
    this.tabs = this.images.map((image, i) =>
      element("button", { type: "button", "data-name": image.name, onclick: () => this.show(i) },
        ...(i < 10 ? [element("kbd", {}, String(i))] : []), image.name),
    );
    // The reference is 0 on the keyboard and last in the row, as 0 is.
    document.getElementById("tabs").replaceChildren(...this.tabs.slice(1), this.tabs[0]);
    this.other = document.getElementById("other");
    this.images.forEach((image, i) => this.other.append(element("option", { value: String(i) }, image.name)));
    this.other.addEventListener("change", () => this.compareWith(Number(this.other.value)));
    this.pressMode = segmented(
      document.getElementById("mode"),
      [
        ["color", "Color", "E"],
        ["error", "Relative error", "E"],
      ],
      this.mode,
      (mode) => this.setMode(mode),
    );
    this.slider = document.getElementById("exposure");
    this.slider.addEventListener("input", () => this.setExposure(Number(this.slider.value)));
    this.slider.addEventListener("dblclick", () => this.setExposure(0));
    this.wipeBox = document.getElementById("wipe");
    this.wipeBox.addEventListener("change", () => this.setWipe(this.wipeBox.checked));
    document.getElementById("fit").addEventListener("click", () => this.fit());
    document.getElementById("actual").addEventListener("click", () => this.zoomTo(1));
    this.#drawScale();
    this.#refreshControls();
  }

  #drawScale() {
    const context = document.getElementById("scale-canvas").getContext("2d");
    for (let x = 0; x < 256; ++x) {
      context.fillStyle = `rgb(${heatColor(x / 255).join()})`;
      context.fillRect(x, 0, 1, 1);
    }
  }

  #refreshControls() {
    this.tabs.forEach((tab, i) => tab.setAttribute("aria-pressed", String(i === this.left)));
    this.other.value = String(this.right);
    this.other.disabled = !this.wipe;
    this.wipeBox.checked = this.wipe;
    this.slider.value = String(this.exposure);
    document.getElementById("exposure-value").textContent =
      `${this.exposure > 0 ? "+" : ""}${this.exposure.toFixed(1)}`.replace("-", "\u2212");
    document.getElementById("scale").hidden = this.mode !== "error";
    this.pressMode(this.mode);
  }

  #changed() {
    this.#refreshControls();
    this.#draw();
    this.#readOut();
  }
  show(index) {
    if (index >= 0 && index < this.images.length) this.left = index;
    this.#changed();
  }
  compareWith(index) {
    if (index >= 0 && index < this.images.length) this.right = index;
    this.#changed();
  }
  setMode(mode) {
    this.mode = mode;
    this.#changed();
  }
  setExposure(stops) {
    this.exposure = Math.min(10, Math.max(-10, Math.round(stops * 10) / 10));
    this.#changed();
  }
  setWipe(on) {
    this.wipe = on;
    this.#changed();
  }

  #shapeStage() {
    const { width, height } = this.size;
    this.stage.style.aspectRatio = `${width} / ${height}`;
  }

  #resize() {
    const box = this.stage.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    this.canvas.width = Math.round(box.width * ratio);
    this.canvas.height = Math.round(box.height * ratio);
    if (this.fitted !== false) this.fit();
    else this.#draw();
  }

  // zoom: CSS pixels for one of the image; origin: where its corner is on the stage.
  fit() {
    const { width, height } = this.size;
    const box = this.stage.getBoundingClientRect();
    this.zoom = Math.min(box.width / width, box.height / height);
    this.origin = { x: (box.width - width * this.zoom) / 2, y: (box.height - height * this.zoom) / 2 };
    this.fitted = true;
    this.#draw();
  }
  zoomTo(zoom, at) {
    const box = this.stage.getBoundingClientRect();
    const fixed = at ?? { x: box.width / 2, y: box.height / 2 };
    const smallest = Math.min(1, box.width / this.size.width, box.height / this.size.height) / 4;
    const next = Math.min(kLargestZoom, Math.max(smallest, zoom));
    const scale = next / this.zoom;
    this.origin = { x: fixed.x - (fixed.x - this.origin.x) * scale, y: fixed.y - (fixed.y - this.origin.y) * scale };
    this.zoom = next;
    this.fitted = false;
    this.#draw();
  }
  pan(dx, dy) {
    this.origin = { x: this.origin.x + dx, y: this.origin.y + dy };
    this.fitted = false;
    this.#draw();
  }

  #draw() {
    if (!this.origin) return;
    const context = this.canvas.getContext("2d");
    const ratio = window.devicePixelRatio || 1;
    const { width, height } = this.canvas;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, width, height);
    context.imageSmoothingEnabled = this.zoom * ratio < 1;
    const edge = this.wipe ? Math.round(this.split * width) : width;
    this.#drawPart(context, this.images[this.left], 0, edge);
    if (this.wipe) this.#drawPart(context, this.images[this.right], edge, width);
    this.#placeOverlays(edge / ratio);
  }

  #drawPart(context, image, from, to) {
    if (to <= from) return;
    const ratio = window.devicePixelRatio || 1;
    const { width, height } = this.size;
    context.save();
    context.beginPath();
    context.rect(from, 0, to - from, this.canvas.height);
    context.clip();
    const source = this.cache.canvasOf(image, this.mode, this.exposure);
    context.drawImage(source, this.origin.x * ratio, this.origin.y * ratio, width * this.zoom * ratio,
      height * this.zoom * ratio);
    context.restore();
  }

  #placeOverlays(edge) {
    const divider = document.getElementById("divider");
    divider.hidden = !this.wipe;
    divider.style.left = `${edge}px`;
    document.getElementById("tag-left").textContent = this.images[this.left].name;
    const right = document.getElementById("tag-right");
    right.hidden = !this.wipe;
    right.textContent = this.images[this.right].name;
    document.getElementById("zoom").textContent =
      this.zoom >= 1 ? `${Number(this.zoom.toPrecision(3))}\u00d7` : `${Math.round(this.zoom * 100)} %`;
  }

  #positionOf(event) {
    const box = this.stage.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top, width: box.width };
  }

  #listen() {
    this.stage.addEventListener("pointerdown", (event) => this.#startDrag(event));
    this.stage.addEventListener("pointermove", (event) => {
      const at = this.#positionOf(event);
      this.pointer = {
        x: Math.floor((at.x - this.origin.x) / this.zoom),
        y: Math.floor((at.y - this.origin.y) / this.zoom),
      };
      this.#readOut();
    });
    this.stage.addEventListener("contextmenu", (event) => event.preventDefault());
    this.stage.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 30 : 1;
        this.zoomTo(this.zoom * 2 ** ((-event.deltaY * lines) / 240), this.#positionOf(event));
      },
      { passive: false },
    );
    window.addEventListener("keydown", (event) => this.#key(event));
  }

  #startDrag(event) {
    this.stage.focus({ preventScroll: true });
    this.stage.setPointerCapture(event.pointerId);
    const wiping = this.wipe && event.button === 0 && !event.shiftKey;
    let last = this.#positionOf(event);
    const move = (next) => {
      const at = this.#positionOf(next);
      if (wiping) {
        this.split = Math.min(1, Math.max(0, at.x / at.width));
        this.#draw();
      } else {
        this.pan(at.x - last.x, at.y - last.y);
      }
      last = at;
    };
    const end = () => {
      this.stage.removeEventListener("pointermove", move);
      this.stage.removeEventListener("pointerup", end);
      this.stage.removeEventListener("pointercancel", end);
    };
    this.stage.addEventListener("pointermove", move);
    this.stage.addEventListener("pointerup", end);
    this.stage.addEventListener("pointercancel", end);
    if (wiping) move(event);
  }

  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || /^(SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
    if (event.target.type === "range" && event.key.startsWith("Arrow")) return;
    const digit = /^(?:Digit|Numpad)(\d)$/.exec(event.code);
    const count = this.images.length;
    const actions = {
      w: () => this.setWipe(!this.wipe),
      e: () => this.setMode(this.mode === "error" ? "color" : "error"),
      f: () => this.fit(),
      a: () => this.zoomTo(1),
      "[": () => this.setExposure(this.exposure - 0.5),
      "]": () => this.setExposure(this.exposure + 0.5),
      "+": () => this.zoomTo(this.zoom * 1.5),
      "-": () => this.zoomTo(this.zoom / 1.5),
      ArrowLeft: () => this.show((this.left + count - 1) % count),
      ArrowRight: () => this.show((this.left + 1) % count),
    };
    const action = digit
      ? () => (event.shiftKey ? this.compareWith(Number(digit[1])) : this.show(Number(digit[1])))
      : actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  #readOut() {
    const { width, height } = this.size;
    const p = this.pointer;
    const inside = p && p.x >= 0 && p.y >= 0 && p.x < width && p.y < height;
    const shown = this.wipe && this.left !== this.right ? [this.left, this.right] : [this.left];
    const rows = shown.map((index) => this.#readOutRow(this.images[index], inside ? p : null));
    const place = element("span", { class: "place" }, inside ? `x ${p.x}  y ${p.y}` : "linear RGB under the pointer");
    document.getElementById("readout").replaceChildren(place, ...rows);
  }

  #readOutRow(image, p) {
    const row = element("span", { class: "pixel", "data-name": image.name }, element("b", {}, image.name));
    if (!p) return row;
    const index = 3 * (p.y * image.width + p.x);
    ["r", "g", "b"].forEach((channel, c) =>
      row.append(element("span", { class: channel }, this.textOf(image.values[index + c]))),
    );
    if (image !== this.images[0]) {
      const error = relativeError(image.values, this.images[0].values, index, this.epsilon);
      row.append(element("span", { class: "error" }, `error ${(100 * error).toPrecision(3)} %`));
    }
    return row;
  }

  start() {
    this.#resize();
    this.#changed();
  }
}
