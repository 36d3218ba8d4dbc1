// The canvas: images of the sides beside each other, all at the same place and zoom.

const kLeastZoom = 1 / 64;
const kMostZoom = 128;

export class Stage {
  constructor(element) {
    this.element = element;
    this.canvas = element.querySelector("canvas");
    this.context = this.canvas.getContext("2d", { alpha: false });
    this.panes = [];
    this.window = [0, 0, 1, 1];
    // Pixels of the page for one of the image, and the place of the full image in the middle of a pane.
    this.view = { zoom: 1, x: 0, y: 0 };
    this.fitted = true;
    this.changed = () => {};
    new ResizeObserver(() => this.resize()).observe(element);
  }

  // How many images there are, and the part of the full image that they show.
  arrange(count, window) {
    const moved = this.window.join() !== window.join() || this.panes.length !== count;
    this.window = window;
    while (this.panes.length > count) this.panes.pop();
    while (this.panes.length < count) this.panes.push({ bitmap: null, preview: false });
    if (moved && this.fitted) this.fit();
    else if (moved) this.draw();
  }

  show(side, image, preview) {
    const pane = this.panes[side];
    if (!pane) return;
    if (!pane.bitmap || pane.bitmap.width !== image.width || pane.bitmap.height !== image.height)
      pane.bitmap = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
    pane.bitmap.getContext("2d").putImageData(image, 0, 0);
    pane.preview = preview;
    this.draw();
  }

  resize() {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth, clientHeight } = this.element;
    this.canvas.width = Math.max(1, Math.round(clientWidth * ratio));
    this.canvas.height = Math.max(1, Math.round(clientHeight * ratio));
    if (this.fitted) this.fit();
    else this.draw();
  }

  paneWidth() {
    return this.element.clientWidth / Math.max(1, this.panes.length);
  }

  fit() {
    const [x, y, width, height] = this.window;
    const zoom = Math.min(this.paneWidth() / width, this.element.clientHeight / height) * 0.97;
    this.view = { zoom, x: x + width / 2, y: y + height / 2 };
    this.fitted = true;
    this.draw();
  }

  actual() {
    const [x, y, width, height] = this.window;
    this.view = { zoom: 1 / (window.devicePixelRatio || 1), x: x + width / 2, y: y + height / 2 };
    this.fitted = false;
    this.draw();
  }

  pan(dx, dy) {
    this.view.x -= dx / this.view.zoom;
    this.view.y -= dy / this.view.zoom;
    this.fitted = false;
    this.draw();
  }

  // Around a place of the stage, which stays below the pointer.
  zoomBy(factor, px, py) {
    const before = this.placeAt(px, py);
    this.view.zoom = Math.min(Math.max(this.view.zoom * factor, kLeastZoom), kMostZoom);
    const after = this.placeAt(px, py);
    this.view.x += before.x - after.x;
    this.view.y += before.y - after.y;
    this.fitted = false;
    this.draw();
  }

  // Which side is there, and which place of the full image.
  placeAt(px, py) {
    const width = this.paneWidth();
    const side = Math.min(Math.max(Math.floor(px / width), 0), Math.max(0, this.panes.length - 1));
    return {
      side,
      x: this.view.x + (px - (side + 0.5) * width) / this.view.zoom,
      y: this.view.y + (py - this.element.clientHeight / 2) / this.view.zoom,
    };
  }

  // Where a place of the full image lies on the stage.
  pointOf(side, x, y) {
    return [
      (side + 0.5) * this.paneWidth() + (x - this.view.x) * this.view.zoom,
      this.element.clientHeight / 2 + (y - this.view.y) * this.view.zoom,
    ];
  }

  draw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.paint();
      this.changed();
    });
  }

  paint() {
    const { context, canvas } = this;
    const ratio = canvas.width / Math.max(1, this.element.clientWidth);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = "#101112";
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const width = this.paneWidth();
    const [x, y, w, h] = this.window;
    this.panes.forEach((pane, side) => {
      if (!pane.bitmap) return;
      context.save();
      context.beginPath();
      context.rect(side * width, 0, width, this.element.clientHeight);
      context.clip();
      context.imageSmoothingEnabled = pane.preview || this.view.zoom * ratio < 1;
      context.imageSmoothingQuality = "medium";
      const [left, top] = this.pointOf(side, x, y);
      context.drawImage(pane.bitmap, left, top, w * this.view.zoom, h * this.view.zoom);
      context.restore();
      if (side > 0) {
        context.fillStyle = "#3a3d41";
        context.fillRect(side * width - 0.5, 0, 1, this.element.clientHeight);
      }
    });
  }
}
