// The scan in 3D, on two canvases that turn together: the belt with the cloud, and the half-sphere of viewpoints with the
// camera. Lengths are millimetres, x along the belt upstream, z up.

const CAMERA_SIZE = 70;

// The two views as one.
export class Scene {
  constructor(belt, sphere) {
    const view = { turn: -0.75, tilt: 0.55, changed: () => this.draw() }; // radians: about the vertical, and from level
    this.canvases = [new View(belt, view, false), new View(sphere, view, true)];
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  // content: {scene, cloud: whether to draw the points, classes: likely class at each position or null, viewpoint, names}
  show(content) {
    for (const canvas of this.canvases) canvas.content = content;
    this.draw();
  }

  draw() {
    for (const canvas of this.canvases) canvas.draw();
  }
}

class View {
  constructor(canvas, view, whole) {
    this.canvas = canvas;
    this.view = view;
    this.whole = whole; // with the half-sphere
    this.zoom = 1;
    this.content = null;
    this.pointers = new Map();
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, event);
    });
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, (event) => this.pointers.delete(event.pointerId));
    }
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom = Math.min(5, Math.max(0.5, this.zoom * Math.exp(-event.deltaY / 600)));
      this.draw();
    }, { passive: false });
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    this.view.turn += (event.clientX - before.clientX) / 150;
    this.view.tilt = Math.min(1.5, Math.max(-0.1, this.view.tilt + (event.clientY - before.clientY) / 150));
    this.pointers.set(event.pointerId, event);
    this.view.changed();
  }

  draw() {
    const { canvas, content } = this;
    const scale = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    canvas.width = width * scale;
    canvas.height = height * scale;
    const pen = canvas.getContext("2d");
    pen.scale(scale, scale);
    if (!content || !content.scene || width === 0) return;
    const style = getComputedStyle(canvas);
    this.colour = (name) => style.getPropertyValue(`--${name}`).trim();
    this.look(width, height);
    if (this.whole) this.drawSphere(pen);
    this.drawBelt(pen);
    if (content.cloud) this.drawCloud(pen);
    if (this.whole) this.drawViewpoints(pen);
  }

  // Choose the middle and the scale so that belt or half-sphere fit.
  look(width, height) {
    const { layout, viewpoints } = this.content.scene;
    const eyes = viewpoints.filter(Boolean);
    this.radius = eyes.length ? eyes.reduce((sum, eye) => sum + Math.hypot(...eye), 0) / eyes.length : 0;
    const length = (layout[0] - 1) * layout[1];
    const reach = this.whole ? Math.max(this.radius, 300) : 0.5 * length + 110;
    this.middle = this.whole ? [0, 0, 0.45 * reach] : [0.5 * length, 0, 40];
    this.scale = (this.zoom * Math.min(width / 2.2, height / (this.whole ? 1.8 : 1.3))) / reach;
    this.centre = [width / 2, height / 2];
    this.axes = [Math.cos(this.view.turn), Math.sin(this.view.turn), Math.cos(this.view.tilt), Math.sin(this.view.tilt)];
  }

  // To the canvas: x, y, and the depth, larger towards the viewer.
  project([x, y, z]) {
    const [c, s, ct, st] = this.axes;
    const [u, v, w] = [x - this.middle[0], y - this.middle[1], z - this.middle[2]];
    const right = c * u + s * v;
    const away = -s * u + c * v;
    return [
      this.centre[0] + this.scale * right,
      this.centre[1] - this.scale * (ct * w + st * away),
      st * w - ct * away,
    ];
  }

  path(pen, points, colour, { width = 1, dash = [], fill = null } = {}) {
    pen.beginPath();
    points.forEach((point, i) => pen[i ? "lineTo" : "moveTo"](...this.project(point).slice(0, 2)));
    pen.setLineDash(dash);
    pen.lineWidth = width;
    pen.strokeStyle = colour;
    if (fill) {
      pen.fillStyle = fill;
      pen.fill();
    }
    pen.stroke();
    pen.setLineDash([]);
  }

  circle(radius, [x, y, z], from = 0, to = 2 * Math.PI) {
    return Array.from({ length: 49 }, (_, i) => {
      const angle = from + ((to - from) * i) / 48;
      return [x + radius * Math.cos(angle), y + radius * Math.sin(angle), z];
    });
  }

  drawSphere(pen) {
    if (!this.radius) return;
    const line = this.colour("line");
    for (const elevation of [0, 30, 60]) {
      const e = (elevation * Math.PI) / 180;
      this.path(pen, this.circle(this.radius * Math.cos(e), [0, 0, this.radius * Math.sin(e)]), line);
    }
    for (let azimuth = 0; azimuth < 180; azimuth += 30) {
      const a = (azimuth * Math.PI) / 180;
      const arc = this.circle(this.radius, [0, 0, 0], 0, Math.PI).map(([across, up]) =>
        [across * Math.cos(a), across * Math.sin(a), up]);
      this.path(pen, arc, line);
    }
  }

  drawBelt(pen) {
    const { layout } = this.content.scene;
    const [positions, spacing, rim, radius] = layout;
    const quiet = this.colour("quiet");
    const [from, to, side] = [-spacing / 2, (positions - 0.5) * spacing, 90];
    this.path(pen, [[from, -side, 0], [to, -side, 0], [to, side, 0], [from, side, 0], [from, -side, 0]], quiet,
      { fill: this.colour("track") });
    for (let j = 0; j < positions; j += 1) {
      const known = this.content.classes?.[j];
      const colour = known == null ? quiet : this.classColour(known);
      this.path(pen, this.circle(radius, [j * spacing, 0, rim]), colour, { width: 2 });
      if (this.whole) continue;
      pen.fillStyle = this.colour("text");
      pen.font = "12px system-ui, sans-serif";
      const [x, y] = this.project([j * spacing, -side - 30, 0]);
      pen.textAlign = x > this.project([j * spacing, 0, 0])[0] ? "left" : "right";
      pen.fillText(j === 0 ? "belt end" : `${j + 1}`, x, y + 8);
    }
  }

  drawCloud(pen) {
    const { points, positions } = this.content.scene;
    const grey = this.colour("cloud");
    const drawn = positions.map((position, i) => {
      const [x, y, depth] = this.project(points.slice(3 * i, 3 * i + 3));
      return [depth, x, y, position];
    });
    drawn.sort((a, b) => a[0] - b[0]);
    for (const [, x, y, position] of drawn) {
      const known = position < 0 ? null : this.content.classes?.[position];
      pen.fillStyle = known == null ? grey : this.classColour(known);
      const size = this.whole ? 1 : position < 0 ? 1.3 : 2.2;
      pen.fillRect(x, y, size, size);
    }
  }

  drawViewpoints(pen) {
    const { scene, viewpoint, names } = this.content;
    scene.viewpoints.forEach((eye, k) => {
      if (!eye) return;
      const here = k === viewpoint;
      const [x, y] = this.project(eye);
      if (here) {
        this.drawCamera(pen, eye);
      } else {
        pen.fillStyle = this.colour("card");
        pen.strokeStyle = this.colour("quiet");
        pen.beginPath();
        pen.arc(x, y, 4, 0, 2 * Math.PI);
        pen.fill();
        pen.stroke();
      }
      pen.fillStyle = this.colour(here ? "text" : "quiet");
      pen.font = `${here ? "bold " : ""}12px system-ui, sans-serif`;
      pen.textAlign = x > this.centre[0] ? "left" : "right";
      pen.fillText(names[k], x + (x > this.centre[0] ? 9 : -9), y - 9);
    });
  }

  // A pyramid that opens towards the belt end.
  drawCamera(pen, eye) {
    const distance = Math.hypot(...eye);
    const forward = eye.map((v) => -v / distance);
    const level = Math.hypot(forward[0], forward[1]) || 1;
    const right = level < 1e-6 ? [1, 0, 0] : [forward[1] / level, -forward[0] / level, 0];
    const down = [
      forward[1] * right[2] - forward[2] * right[1],
      forward[2] * right[0] - forward[0] * right[2],
      forward[0] * right[1] - forward[1] * right[0],
    ];
    const corner = (u, v) => eye.map((e, i) =>
      e + 1.6 * CAMERA_SIZE * forward[i] + CAMERA_SIZE * (u * right[i] + 0.75 * v * down[i]));
    const corners = [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)];
    const colour = this.colour("accent");
    this.path(pen, [eye, [0, 0, 0]], colour, { dash: [2, 4] });
    this.path(pen, [...corners, corners[0]], colour, { width: 1.5 });
    for (const end of corners) this.path(pen, [eye, end], colour, { width: 1.5 });
  }

  classColour(index) {
    return this.colour(`class-${index % 8}`);
  }
}
