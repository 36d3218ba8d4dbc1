// What dragging, the wheel and arrow keys do: look around in the image, move the camera, or choose a crop.
import { command } from "./server.js";

// Motions of the camera while one is on its way to the program go with the next.
class Camera {
  constructor(failed) {
    this.failed = failed;
    this.motion = null;
    this.busy = false;
  }
  add(motion) {
    const sum = (this.motion ??= { begins: false, yaw: 0, pitch: 0, dolly: 1, right: 0, up: 0 });
    sum.begins ||= motion.begins ?? false;
    for (const name of ["yaw", "pitch", "right", "up"]) sum[name] += motion[name] ?? 0;
    sum.dolly *= motion.dolly ?? 1;
    this.send();
  }
  async send() {
    if (this.busy) return;
    this.busy = true;
    while (this.motion) {
      const motion = this.motion;
      this.motion = null;
      await command("move", motion).catch(this.failed);
    }
    this.busy = false;
  }
}

export class Hands {
  constructor(stage, selection, failed) {
    this.stage = stage;
    this.element = stage.element;
    this.selection = selection;
    this.failed = failed;
    this.camera = new Camera(failed);
    this.hand = "look";
    this.image = [1, 1];
    this.drag = null;
    this.lastWheel = 0;
    const on = (name, handler, options) => this.element.addEventListener(name, handler, options);
    on("pointerdown", (event) => this.down(event));
    on("pointermove", (event) => this.move(event));
    on("pointerup", (event) => this.up(event));
    on("pointercancel", () => this.cancel());
    on("wheel", (event) => this.wheel(event), { passive: false });
    on("contextmenu", (event) => this.hand === "camera" && event.preventDefault());
  }

  choose(hand) {
    this.hand = hand;
    this.element.dataset.hand = hand;
    this.cancel();
  }

  at(event) {
    const box = this.element.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  down(event) {
    if (event.target.closest(".tools")) return;
    this.element.focus({ preventScroll: true });
    this.element.setPointerCapture(event.pointerId);
    const [x, y] = this.at(event);
    const beside = event.shiftKey || event.button !== 0;
    this.drag = { x, y, startX: x, startY: y, side: this.stage.placeAt(x, y).side, beside, begins: true };
  }

  move(event) {
    const { drag, stage } = this;
    if (!drag) return;
    const [x, y] = this.at(event);
    const dx = x - drag.x;
    const dy = y - drag.y;
    drag.x = x;
    drag.y = y;
    if (this.hand === "look") {
      stage.pan(dx, dy);
    } else if (this.hand === "crop") {
      this.select();
    } else {
      const begins = drag.begins;
      drag.begins = false;
      if (drag.beside) {
        const width = stage.view.zoom * this.image[0];
        this.camera.add({ begins, right: -dx / width, up: dy / width });
      } else {
        const turn = Math.PI / stage.paneWidth();
        this.camera.add({ begins, yaw: -dx * turn, pitch: -dy * turn });
      }
    }
  }

  up() {
    const crop = this.hand === "crop" && this.drag ? this.rectangle() : null;
    this.cancel();
    if (crop && crop.width >= 2 && crop.height >= 2) command("crop", crop).catch(this.failed);
  }

  cancel() {
    this.drag = null;
    this.selection.hidden = true;
  }

  // The pixels of the image between where the drag began and where it is.
  rectangle() {
    const { drag, stage } = this;
    const a = stage.placeAt(drag.startX, drag.startY);
    const [ox, oy] = stage.pointOf(drag.side, 0, 0);
    const b = { x: (drag.x - ox) / stage.view.zoom, y: (drag.y - oy) / stage.view.zoom };
    const inside = (value, most) => Math.min(Math.max(value, 0), most);
    const [width, height] = this.image;
    const left = Math.floor(inside(Math.min(a.x, b.x), width));
    const top = Math.floor(inside(Math.min(a.y, b.y), height));
    return {
      x: left,
      y: top,
      width: Math.ceil(inside(Math.max(a.x, b.x), width)) - left,
      height: Math.ceil(inside(Math.max(a.y, b.y), height)) - top,
    };
  }

  select() {
    const crop = this.rectangle();
    const [left, top] = this.stage.pointOf(this.drag.side, crop.x, crop.y);
    const { zoom } = this.stage.view;
    Object.assign(this.selection.style, {
      left: `${left}px`,
      top: `${top}px`,
      width: `${crop.width * zoom}px`,
      height: `${crop.height * zoom}px`,
    });
    this.selection.hidden = false;
  }

  wheel(event) {
    event.preventDefault();
    const [x, y] = this.at(event);
    const amount = event.deltaY * (event.deltaMode === 1 ? 24 : 1);
    if (this.hand !== "camera") return this.stage.zoomBy(2 ** (-amount / 240), x, y);
    const begins = event.timeStamp - this.lastWheel > 600;
    this.lastWheel = event.timeStamp;
    this.camera.add({ begins, dolly: 2 ** (amount / 800) });
  }

  // Arrows, plus and minus; false for other keys.
  key(key) {
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const zooms = { "+": 1, "=": 1, "-": -1 };
    const { stage, camera } = this;
    const moves = this.hand === "camera";
    if (arrows[key]) {
      const [x, y] = arrows[key];
      if (moves) camera.add({ begins: true, yaw: -0.06 * x, pitch: -0.06 * y });
      else stage.pan(-40 * x, -40 * y);
    } else if (zooms[key]) {
      if (moves) camera.add({ begins: true, dolly: 2 ** (-0.15 * zooms[key]) });
      else stage.zoomBy(2 ** (0.5 * zooms[key]), this.element.clientWidth / 2, this.element.clientHeight / 2);
    } else {
      return false;
    }
    return true;
  }
}
